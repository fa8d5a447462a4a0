-- SPDX-License-Identifier: GPL-3.0-or-later
-- (id) -> 1 if the job existed, otherwise 0
local id = ARGV[1]
if not field(id, 'created') then return 0 end
remove(id)
notify('stop ' .. id)
notify('changed ' .. id)
return 1
