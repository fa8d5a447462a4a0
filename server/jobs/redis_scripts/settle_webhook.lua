-- SPDX-License-Identifier: GPL-3.0-or-later
-- (id, milliseconds until the next attempt; empty: none) -> 1
if ARGV[2] == '' then
    redis.call('ZREM', key('webhooks'), ARGV[1])
    redis.call('HDEL', job_key(ARGV[1]), 'callback', 'attempts')
else
    redis.call('ZADD', key('webhooks'), 'XX', now + tonumber(ARGV[2]), ARGV[1])
end
return 1
