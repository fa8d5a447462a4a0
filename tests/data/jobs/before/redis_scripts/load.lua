-- -> jobs that wait, that are claimed, bytes kept
return {redis.call('ZCARD', key('queue')), redis.call('ZCARD', key('leases')), state('bytes')}
