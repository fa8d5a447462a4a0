-- SPDX-License-Identifier: GPL-3.0-or-later
-- (id, claim, lease in milliseconds, status, fraction, iteration, variation or empty)
-- -> still, cancelled or lost, and the time
local id = ARGV[1]
if not owns(id, ARGV[2]) then
    return {field(id, 'status') == 'cancelled' and 'cancelled' or 'lost', string.format('%.0f', now)}
end
redis.call('ZADD', key('leases'), now + tonumber(ARGV[3]), id)
if ARGV[4] == 'running' then redis.call('HSETNX', job_key(id), 'started', now) end
if field(id, 'status') ~= ARGV[4] or field(id, 'fraction') ~= ARGV[5] then
    redis.call('HSET', job_key(id), 'status', ARGV[4], 'fraction', ARGV[5], 'iteration', ARGV[6])
    if ARGV[7] ~= '' then redis.call('HSET', job_key(id), 'variation', ARGV[7]) end
    notify('changed ' .. id)
end
return {'still', string.format('%.0f', now)}
