-- SPDX-License-Identifier: GPL-3.0-or-later
-- Functions shared by all scripts. The keys, after the prefix in KEYS[1]:
--
--   job:ID       hash   the data of a job, without bodies
--   question:ID  hash   path, query, content_type, accept, their digest, size of the body, and the body in pieces: 0, 1
--                       and so on, with the digests digest:0, digest:1
--   result:ID    hash   the result in pieces, with digests
--   queue        zset   places of waiting jobs, by start tag; a place is a number of 16 digits followed by the id
--   had          zset   clients, by finish tag: start-time fair queueing, as in fair_queue.h
--   waiting      hash   clients, with the number of their waiting jobs
--   leases       zset   ids of claimed jobs, by the time when their leases expire
--   finished     zset   ids of finished jobs, by the time of their end in microseconds
--   results      zset   ids of finished jobs with a result, by the same time
--   webhooks     zset   ids of jobs whose webhooks are not sent yet, by the time of the next attempt
--   state        hash   turn: the virtual time; places, claims: last numbers assigned; bytes: stored bytes
--   news         channel: `work`, `changed ID`, `stop ID`

local prefix = KEYS[1]
local time = redis.call('TIME')
local exact_now = time[1] * 1000000 + time[2]    -- microseconds
local now = math.floor(exact_now / 1000)         -- milliseconds

local function key(name) return prefix .. name end
local function job_key(id) return prefix .. 'job:' .. id end
local function question_key(id) return prefix .. 'question:' .. id end
local function result_key(id) return prefix .. 'result:' .. id end

local function notify(news) redis.call('PUBLISH', key('news'), news) end

local function state(name) return tonumber(redis.call('HGET', key('state'), name) or '0') end

local function field(id, name) return redis.call('HGET', job_key(id), name) end

local types = {queue = 'zset', had = 'zset', waiting = 'hash', leases = 'zset', finished = 'zset', results = 'zset',
    webhooks = 'zset', state = 'hash'}

local function has_type(any_key, expected)
    local found = redis.call('TYPE', any_key).ok
    return found == 'none' or found == expected
end

-- Returns those keys shared by all jobs that are damaged: their values differ from what these scripts write.
local function find_damaged_keys()
    local wrong = {}
    for name, expected in pairs(types) do
        if not has_type(key(name), expected) then table.insert(wrong, key(name)) end
    end
    if #wrong > 0 then return wrong end
    local counters = redis.call('HMGET', key('state'), 'places', 'claims', 'bytes', 'turn')
    for i, value in ipairs(counters) do
        local is_sound = i == 4 and tonumber(value) or value and #value < 16 and string.find(value, '^-?%d+$')
        if value and not is_sound then return {key('state')} end
    end
    local lacks_counters = not counters[3] and redis.call('EXISTS', key('queue'), key('leases'), key('finished')) > 0
    return lacks_counters and {key('state')} or {}
end

local has_ended = {queued = false, running = false, succeeded = true, failed = true, cancelled = true}
local checked_fields = {'status', 'place', 'owner', 'client',
    'memory', 'starts', 'claim', 'created', 'bytes', 'iteration',  -- whole numbers
    'seconds', 'fraction',  -- numbers
    'finished', 'started', 'result_bytes', 'failure', 'partial', 'dropped', 'variation', 'turn'}  -- numbers or missing
local place_pattern = '^' .. string.rep('%d', 16)

-- Returns whether the data of a job has the form that these scripts write. The key must be a hash.
local function is_sound(id)
    local values = redis.call('HMGET', job_key(id), unpack(checked_fields))
    local ended, place = has_ended[values[1]], values[2]
    if ended == nil or ended ~= (values[13] ~= false) or not values[3] or not values[4] then return false end
    local is_place = place and #place == 16 + #id and string.find(place, place_pattern)
    if not ended and not is_place then return false end
    for i = 5, 10 do
        local value = values[i]
        if not value or #value > 20 or not string.find(value, '^%d+$') then return false end
    end
    for i = 11, #checked_fields do
        local value = values[i]
        if value and not tonumber(value) or not value and i < 13 then return false end
    end
    return true
end

-- Returns whether a job is listed where its state requires: as finished, or in the queue or with a lease.
local function is_placed(id)
    if field(id, 'finished') then return redis.call('ZSCORE', key('finished'), id) end
    local place = field(id, 'place')
    return redis.call('ZSCORE', key('leases'), id) or place and redis.call('ZSCORE', key('queue'), place)
end

-- Ends a script with an error. The server then runs repair.lua and repeats the script.
local function fail_as_damaged(any_key) error('DAMAGED ' .. any_key) end

local function is_full(client, limit)
    local waiting = redis.call('ZCARD', key('queue'))
    if waiting < limit then return false end
    return waiting >= 2 * limit or redis.call('HEXISTS', key('waiting'), client) == 1
end

-- Stores a body: the key `uploaded` or, if that is empty, `fields`.
local function put(body_key, uploaded, fields)
    if uploaded == '' then
        redis.call('UNLINK', body_key)  -- of any type
        redis.call('HSET', body_key, unpack(fields))
    else
        redis.call('RENAME', uploaded, body_key)
        redis.call('PERSIST', body_key)
    end
end

local function discard(uploaded)
    if uploaded ~= '' then redis.call('UNLINK', uploaded) end
end

-- Sets the bytes that a job takes, and updates the total.
local function set_bytes(id, bytes)
    local before = tonumber(field(id, 'bytes') or '0')
    redis.call('HINCRBY', key('state'), 'bytes', bytes - before)
    redis.call('HSET', job_key(id), 'bytes', bytes)
end

local function enter_queue(id, turn, place)
    redis.call('HSET', job_key(id), 'place', place)
    redis.call('ZADD', key('queue'), turn, place)
    redis.call('HINCRBY', key('waiting'), field(id, 'client'), 1)
    notify('work')
end

-- Removes a job from the queue. Returns its start tag, or nothing if it was not in the queue.
local function leave_queue(id)
    local place = field(id, 'place')
    local turn = place and redis.call('ZSCORE', key('queue'), place)
    if not turn then return nil end
    redis.call('ZREM', key('queue'), place)
    local client = field(id, 'client')
    if redis.call('HINCRBY', key('waiting'), client, -1) <= 0 then redis.call('HDEL', key('waiting'), client) end
    return tonumber(turn)
end

-- Returns the memory that the job at a place of the queue needs, or nothing if its data is incomplete because other
-- programs or Redis have deleted keys.
local function memory_at(id, place)
    local known = redis.call('HMGET', job_key(id), 'place', 'client', 'memory', 'seconds')
    return known[1] == place and known[2] and tonumber(known[4]) and tonumber(known[3])
end

-- Forgets the service that clients have received if the queue is empty.
local function forget_turns_if_empty()
    if redis.call('EXISTS', key('queue')) == 1 then return end
    redis.call('DEL', key('had'), key('waiting'))
    redis.call('HDEL', key('state'), 'turn')
end

-- Replaces the estimated seconds of a claimed job by those used, in the service that its client has received. If they
-- differ by more than a second, also moves the waiting jobs of the client, which takes longer.
local function charge(id, used)
    if used <= 0 or redis.call('EXISTS', key('queue')) == 0 then return end
    local client, more = field(id, 'client'), used - tonumber(field(id, 'seconds'))
    local had = tonumber(redis.call('ZSCORE', key('had'), client) or 'nil')
    if not had and more < 0 then return end  -- the estimate is already forgotten
    redis.call('ZADD', key('had'), more + (had or state('turn')), client)
    if math.abs(more) < 1 or redis.call('HEXISTS', key('waiting'), client) == 0 then return end
    for _, place in ipairs(redis.call('ZRANGE', key('queue'), 0, -1)) do
        if field(string.sub(place, 17), 'client') == client then redis.call('ZINCRBY', key('queue'), more, place) end
    end
end

-- Returns a claimed job to the front of the queue.
local function put_back(id)
    redis.call('ZREM', key('leases'), id)
    if not memory_at(id, field(id, 'place')) then return end
    redis.call('HSET', job_key(id), 'status', 'queued', 'fraction', 0, 'iteration', 0)
    redis.call('HDEL', job_key(id), 'started', 'variation')
    enter_queue(id, math.min(tonumber(field(id, 'turn') or '0'), state('turn')), field(id, 'place'))
    notify('changed ' .. id)
end

-- Removes a job from the queue and ends its claim.
local function withdraw(id)
    redis.call('ZREM', key('leases'), id)
    if leave_queue(id) then
        local client = field(id, 'client')
        if redis.call('ZSCORE', key('had'), client) then
            redis.call('ZINCRBY', key('had'), -tonumber(field(id, 'seconds')), client)
        end
        forget_turns_if_empty()
    end
end

-- Makes the webhook of a job that has ended due, if it has one.
local function wake_webhook(id) redis.call('ZADD', key('webhooks'), 'XX', now, id) end

local function remove(id)
    withdraw(id)
    set_bytes(id, 0)
    redis.call('ZREM', key('finished'), id)
    redis.call('ZREM', key('results'), id)
    redis.call('ZREM', key('webhooks'), id)
    redis.call('UNLINK', job_key(id), question_key(id), result_key(id))
end

-- Deletes the oldest results, and then the jobs that finished first, until there is space for `bytes`.
local function free_space(bytes, limit)
    while state('bytes') + bytes > limit do
        local dropped = redis.call('ZPOPMIN', key('results'))[1]
        local oldest = not dropped and redis.call('ZRANGE', key('finished'), 0, 0)[1]
        if dropped then
            redis.call('UNLINK', result_key(dropped))
            local bytes, of_result = tonumber(field(dropped, 'bytes')), tonumber(field(dropped, 'result_bytes'))
            if bytes and of_result then
                redis.call('HSET', job_key(dropped), 'dropped', 1)
                set_bytes(dropped, bytes - of_result)
            end
        elseif oldest then
            remove(oldest)
        else
            return false
        end
    end
    return true
end

-- Returns whether a claim is the latest one of a job and its lease still exists.
local function owns(id, claim)
    local latest, is_leased = field(id, 'claim'), redis.call('ZSCORE', key('leases'), id) ~= false
    if latest == claim and not is_placed(id) or is_leased and not latest then fail_as_damaged(job_key(id)) end
    return latest == claim and is_leased
end

local function expired(id, ttl)
    local finished = field(id, 'finished')
    return finished and tonumber(finished) + tonumber(ttl) <= now
end
