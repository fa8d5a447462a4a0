-- SPDX-License-Identifier: GPL-3.0-or-later
-- (id, milliseconds that jobs are kept) -> the job
if redis.call('EXISTS', job_key(ARGV[1])) == 0 then return false end
if not is_sound(ARGV[1]) or not is_placed(ARGV[1]) then fail_as_damaged(job_key(ARGV[1])) end
if expired(ARGV[1], ARGV[2]) then return false end
return redis.call('HGETALL', job_key(ARGV[1]))
