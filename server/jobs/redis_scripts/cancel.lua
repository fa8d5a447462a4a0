-- SPDX-License-Identifier: GPL-3.0-or-later
-- (id, bytes of the job after cancellation) -> the job, unless it does not exist or has ended
local id = ARGV[1]
if not field(id, 'created') or field(id, 'finished') then return false end
withdraw(id)
redis.call('UNLINK', question_key(id))
redis.call('ZADD', key('finished'), exact_now, id)
redis.call('HSET', job_key(id), 'status', 'cancelled', 'finished', now, 'result_bytes', 0)
set_bytes(id, tonumber(ARGV[2]))
wake_webhook(id)
notify('stop ' .. id)
notify('changed ' .. id)
return redis.call('HGETALL', job_key(id))
