-- SPDX-License-Identifier: GPL-3.0-or-later
-- (lease in milliseconds) -> id, number of attempts and job of a webhook that is due
--
-- Webhooks of unfinished jobs are looked at again after a lease, because servers of earlier releases end jobs without
-- making their webhooks due.
for _, id in ipairs(redis.call('ZRANGEBYSCORE', key('webhooks'), '-inf', now, 'LIMIT', 0, 100)) do
    redis.call('ZADD', key('webhooks'), now + tonumber(ARGV[1]), id)
    if not field(id, 'callback') then
        redis.call('ZREM', key('webhooks'), id)
    elseif field(id, 'finished') then
        return {id, redis.call('HINCRBY', job_key(id), 'attempts', 1), redis.call('HGETALL', job_key(id))}
    end
end
return false
