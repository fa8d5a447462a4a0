-- SPDX-License-Identifier: GPL-3.0-or-later
-- (id, claim, whether the run counts as a start: 1 or 0) -> 1
if owns(ARGV[1], ARGV[2]) then
    if ARGV[3] == '0' then redis.call('HINCRBY', job_key(ARGV[1]), 'starts', -1) end
    put_back(ARGV[1])
end
return 1
