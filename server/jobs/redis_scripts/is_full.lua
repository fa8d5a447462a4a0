-- SPDX-License-Identifier: GPL-3.0-or-later
-- (client, limit of waiting jobs) -> 1 or 0
return is_full(ARGV[1], tonumber(ARGV[2])) and 1 or 0
