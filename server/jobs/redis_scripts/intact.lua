-- SPDX-License-Identifier: GPL-3.0-or-later
-- Follows common.lua in all scripts except find.lua and repair.lua. Stops the script before it changes anything if a
-- shared key is damaged.
for _, damaged_key in ipairs(find_damaged_keys()) do fail_as_damaged(damaged_key) end
