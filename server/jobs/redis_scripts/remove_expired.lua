-- SPDX-License-Identifier: GPL-3.0-or-later
-- (milliseconds that jobs are kept, maximum number of jobs to remove) -> number of removed jobs
local latest = (now - tonumber(ARGV[1])) * 1000 + 999
local ids = redis.call('ZRANGEBYSCORE', key('finished'), '-inf', latest, 'LIMIT', 0, ARGV[2])
for _, id in ipairs(ids) do remove(id) end
return #ids
