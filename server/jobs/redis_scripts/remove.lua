-- SPDX-License-Identifier: GPL-3.0-or-later
-- (id) -> 1 if the job existed, otherwise 0
local id = ARGV[1]
if not field(id, 'created') then return 0 end
remove(id)
tell('stop ' .. id)
tell('changed ' .. id)
return 1
