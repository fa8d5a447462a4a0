-- Comes after common.lua in all scripts but find.lua and repair.lua: they change nothing where a shared key is
-- damaged.
for _, damaged_key in ipairs(find_damaged_keys()) do fail_as_damaged(damaged_key) end
