-- id, milliseconds that jobs are kept -> the job
if not field(ARGV[1], 'created') or expired(ARGV[1], ARGV[2]) then return false end
return redis.call('HGETALL', job_key(ARGV[1]))
