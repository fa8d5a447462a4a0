-- SPDX-License-Identifier: GPL-3.0-or-later
-- (memory, lease in milliseconds, whether jobs with expired leases may be claimed: 1 or 0) -> id and job
local memory = tonumber(ARGV[1])

if ARGV[3] == '1' then
    for _, id in ipairs(redis.call('ZRANGEBYSCORE', key('leases'), '-inf', now, 'LIMIT', 0, 100)) do put_back(id) end
end

local function claim(id)
    local turn = leave_queue(id)
    redis.call('HSET', key('state'), 'turn', math.max(turn, state('turn')))
    redis.call('ZREMRANGEBYSCORE', key('had'), '-inf', state('turn'))
    forget_turns_if_empty()
    redis.call('ZADD', key('leases'), now + tonumber(ARGV[2]), id)
    redis.call('HINCRBY', job_key(id), 'starts', 1)
    redis.call('HSET', job_key(id), 'turn', turn, 'claim', redis.call('HINCRBY', key('state'), 'claims', 1))
    return {id, redis.call('HGETALL', job_key(id))}
end

local first = 0
while true do
    local places = redis.call('ZRANGE', key('queue'), first, first + 15)
    if #places == 0 then return false end
    for _, place in ipairs(places) do
        local id = string.sub(place, 17)
        local taken = memory_at(id, place)
        if (not taken or taken <= memory) and redis.call('EXISTS', job_key(id)) == 1 and not is_sound(id) then
            fail_as_damaged(job_key(id))
        elseif not taken then
            redis.call('ZREM', key('queue'), place)
            first = first - 1
        elseif taken <= memory then
            return claim(id)
        end
    end
    first = first + #places
end
