-- id, where its question is, bytes, jobs that may wait, bytes that may be kept, owner, client, memory, seconds
-- -> accepted and when it was, full, no room
local id, uploaded, bytes, client = ARGV[1], ARGV[2], tonumber(ARGV[3]), ARGV[7]
local created = field(id, 'created')
if created or is_full(client, tonumber(ARGV[4])) then
    redis.call('UNLINK', uploaded)
    return created and {'accepted', created} or {'full'}
end
if not make_room(bytes, tonumber(ARGV[5])) then
    redis.call('UNLINK', uploaded)
    return {'no room'}
end
redis.call('RENAME', uploaded, question_key(id))
redis.call('PERSIST', question_key(id))
local turn = math.max(state('turn'), tonumber(redis.call('ZSCORE', key('had'), client) or '0'))
redis.call('ZADD', key('had'), turn + tonumber(ARGV[9]), client)
redis.call('HSET', job_key(id), 'owner', ARGV[6], 'client', client, 'memory', ARGV[8], 'seconds', ARGV[9],
    'status', 'queued', 'starts', 0, 'claim', 0, 'created', now, 'fraction', 0, 'iteration', 0)
set_bytes(id, bytes)
enter_queue(id, turn, string.format('%016d', redis.call('HINCRBY', key('state'), 'places', 1)) .. id)
return {'accepted', tostring(field(id, 'created'))}
