-- SPDX-License-Identifier: GPL-3.0-or-later
-- Sends requests from files in turn and compares each answer with the known one. Each thread has one connection, so
-- that answers arrive in the order of requests. Argument: the folder of N.request, N.answer and N.status.

local threads = {}

function setup(thread)
  table.insert(threads, thread)
end

local function read(path)
  local file = io.open(path, "rb")
  if not file then return nil end
  local text = file:read("*a")
  file:close()
  return text
end

local requests, answers, statuses = {}, {}, {}
local last, wait = 0, 0

function init(arguments)
  right, wrong, put_off, first_wrong = 0, 0, 0, ""
  repeat
    local name = arguments[1] .. "/" .. #requests
    local text = read(name .. ".request")
    if text then
      table.insert(answers, read(name .. ".answer"))
      table.insert(statuses, tonumber(read(name .. ".status")))
      table.insert(requests, text)
    end
  until not text
end

function delay()
  local now = wait
  wait = 0
  return now
end

function request()
  last = last % #requests + 1
  return requests[last]
end

local function essence(body)
  return (body:gsub('"elapsed_ms":[-+.%de]+', '""'):gsub('"instance":"[^"]*"', '""'))
end

function response(status, headers, body)
  local retry = tonumber(headers["Retry-After"])
  if (status == 429 or status == 503) and retry then
    put_off = put_off + 1
    wait = 1000 * retry
  elseif status == statuses[last] and essence(body) == answers[last] then
    right = right + 1
  else
    wrong = wrong + 1
    if first_wrong == "" then first_wrong = status .. " " .. body:sub(1, 200):gsub("\n", " ") end
  end
end

function done(summary)
  local sum = {right = 0, wrong = 0, put_off = 0}
  local first = ""
  for _, thread in ipairs(threads) do
    for name in pairs(sum) do sum[name] = sum[name] + thread:get(name) end
    if first == "" then first = thread:get("first_wrong") end
  end
  local errors = summary.errors
  print(string.format("right %d wrong %d put off %d lost %d first %s", sum.right, sum.wrong, sum.put_off,
                      errors.connect + errors.read + errors.write + errors.timeout, first))
end
