-- SPDX-License-Identifier: GPL-3.0-or-later
-- (id, key of the uploaded question or empty, bytes, limit of waiting jobs, limit of stored bytes, owner, client,
-- memory, seconds, traceparent or empty, callback or empty, then the fields of a question that was not uploaded)
-- -> accepted and the time of creation, full, store full
local id, uploaded, bytes, client = ARGV[1], ARGV[2], tonumber(ARGV[3]), ARGV[7]
local created = field(id, 'created')
if created or is_full(client, tonumber(ARGV[4])) then
    discard(uploaded)
    return created and {'accepted', created} or {'full'}
end
if not free_space(bytes, tonumber(ARGV[5])) then
    discard(uploaded)
    return {'store full'}
end
put(question_key(id), uploaded, {unpack(ARGV, 12)})
local turn = math.max(state('turn'), tonumber(redis.call('ZSCORE', key('had'), client) or '0'))
redis.call('ZADD', key('had'), turn + tonumber(ARGV[9]), client)
redis.call('HSET', job_key(id), 'owner', ARGV[6], 'client', client, 'memory', ARGV[8], 'seconds', ARGV[9],
    'status', 'queued', 'starts', 0, 'claim', 0, 'created', now, 'fraction', 0, 'iteration', 0)
if ARGV[10] ~= '' then redis.call('HSET', job_key(id), 'traceparent', ARGV[10]) end
if ARGV[11] ~= '' then
    redis.call('HSET', job_key(id), 'callback', ARGV[11])
    redis.call('ZADD', key('webhooks'), now, id)
end
set_bytes(id, bytes)
enter_queue(id, turn, string.format('%016d', redis.call('HINCRBY', key('state'), 'places', 1)) .. id)
return {'accepted', tostring(field(id, 'created'))}
