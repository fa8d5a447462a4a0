-- SPDX-License-Identifier: GPL-3.0-or-later
-- () -> number of waiting jobs, number of claimed jobs, stored bytes
return {redis.call('ZCARD', key('queue')), redis.call('ZCARD', key('leases')), state('bytes')}
