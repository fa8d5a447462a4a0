-- SPDX-License-Identifier: GPL-3.0-or-later
-- (id, claim, key of the uploaded result or empty, its bytes, bytes of the job after its end, limit of stored bytes,
-- a result that was not uploaded and its digest, seconds of processor time used or 0, then names and values of the
-- job's fields)
-- -> finished and the time, lost, store full
local id, uploaded, bytes = ARGV[1], ARGV[3], tonumber(ARGV[4])

local function refuse(why)
    discard(uploaded)
    return why
end

if not owns(id, ARGV[2]) then
    local finished = field(id, 'finished')  -- finished by this claim in an earlier call, whose reply was lost
    if finished and field(id, 'claim') == ARGV[2] and field(id, 'status') ~= 'cancelled' then
        return refuse({'finished', finished})
    end
    return refuse({'lost'})
end
if bytes > 0 then
    if not free_space(bytes, tonumber(ARGV[6])) then return refuse({'store full'}) end
    put(result_key(id), uploaded, {'size', bytes, '0', ARGV[7], 'digest:0', ARGV[8]})
    redis.call('ZADD', key('results'), exact_now, id)
end
redis.call('ZREM', key('leases'), id)
redis.call('UNLINK', question_key(id))
redis.call('ZADD', key('finished'), exact_now, id)
redis.call('HSET', job_key(id), 'finished', now, 'result_bytes', bytes, unpack(ARGV, 10))
set_bytes(id, tonumber(ARGV[5]))
charge(id, tonumber(ARGV[9]))
wake_webhook(id)
notify('changed ' .. id)
return {'finished', field(id, 'finished')}
