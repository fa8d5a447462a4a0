-- SPDX-License-Identifier: GPL-3.0-or-later
-- (id, claim) -> 1
if owns(ARGV[1], ARGV[2]) then
    redis.call('HINCRBY', job_key(ARGV[1]), 'starts', -1)
    put_back(ARGV[1])
end
return 1
