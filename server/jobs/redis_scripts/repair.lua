-- SPDX-License-Identifier: GPL-3.0-or-later
-- (bytes of a job without bodies, lease in milliseconds) -> the damaged keys
--
-- Repairs keys that were overwritten or deleted. Fails damaged jobs, or removes them if their owner is unknown.
-- Rebuilds the keys that all jobs share from the jobs.
local found = find_damaged_keys()
local was_found = {}
for _, damaged_key in ipairs(found) do
    redis.call('UNLINK', damaged_key)
    was_found[damaged_key] = true
end
for _, count in ipairs(redis.call('HVALS', key('waiting'))) do
    if not string.find(count, '^%d+$') then
        table.insert(found, key('waiting'))
        break
    end
end

-- Fails a damaged job. Keeps only the owner and, if valid, the time of creation. The new claim number belongs to no
-- server.
local function fail(id)
    local owner, created, claim = field(id, 'owner'), tonumber(field(id, 'created')), tonumber(field(id, 'claim'))
    redis.call('UNLINK', job_key(id), question_key(id), result_key(id))
    redis.call('HSET', job_key(id), 'owner', owner, 'client', owner, 'memory', 0, 'seconds', 0, 'status', 'failed',
        'starts', 0, 'claim', string.format('%.0f', math.max(claim or 0, state('claims')) + 1),
        'created', string.format('%.0f', math.min(math.abs(created or now), now)),
        'fraction', 0, 'iteration', 0, 'finished', now, 'result_bytes', 0, 'bytes', ARGV[1],
        'failure', 500, 'message', 'the data of this job in Redis was damaged', 'field', '')
    redis.call('ZADD', key('finished'), exact_now, id)
end

-- Fails or removes damaged jobs, and returns the ids of the remaining jobs.
local function repair_jobs()
    local ids = {}
    for _, any_key in ipairs(redis.call('KEYS', prefix .. 'job:*')) do
        local id = string.sub(any_key, #prefix + 5)
        local is_hash = redis.call('TYPE', any_key).ok == 'hash'
        if is_hash and is_sound(id) then
            table.insert(ids, id)
        else
            table.insert(found, any_key)
            if is_hash and field(id, 'owner') then
                fail(id)
                table.insert(ids, id)
            else
                redis.call('UNLINK', any_key, question_key(id), result_key(id))
            end
            notify('stop ' .. id)
            notify('changed ' .. id)
        end
    end
    return ids
end

-- Returns the scores of a sorted set, and removes it.
local function take_scores(name)
    local scores, all = {}, redis.call('ZRANGE', key(name), 0, -1, 'WITHSCORES')
    for i = 1, #all, 2 do scores[all[i]] = all[i + 1] end
    redis.call('UNLINK', key(name))
    return scores
end

local ids = repair_jobs()
local queued, leased, finished = take_scores('queue'), take_scores('leases'), take_scores('finished')
local turn, places, claims, bytes = state('turn'), state('places'), state('claims'), 0
local lost = {}  -- names of keys from which jobs were missing
redis.call('UNLINK', key('waiting'), key('results'))

for _, id in ipairs(ids) do
    bytes = bytes + tonumber(field(id, 'bytes'))
    claims = math.max(claims, tonumber(field(id, 'claim')))
    if field(id, 'callback') then redis.call('ZADD', key('webhooks'), 'NX', now, id) end
    if field(id, 'finished') then
        if not finished[id] then lost.finished = true end
        local when = finished[id] or tonumber(field(id, 'finished')) * 1000
        redis.call('ZADD', key('finished'), when, id)
        if tonumber(field(id, 'result_bytes') or '0') > 0 and redis.call('EXISTS', result_key(id)) == 1 then
            redis.call('ZADD', key('results'), when, id)
        end
    else
        local place = field(id, 'place')
        local is_running = field(id, 'status') == 'running'
        if not leased[id] and not queued[place] then lost[is_running and 'leases' or 'queue'] = true end
        places = math.max(places, tonumber(string.sub(place, 1, 16)))
        if leased[id] or is_running then
            redis.call('ZADD', key('leases'), leased[id] or now + tonumber(ARGV[2]), id)
        else
            enter_queue(id, queued[place] or tonumber(field(id, 'turn') or turn), place)
        end
    end
end
redis.call('HSET', key('state'), 'turn', turn, 'places', string.format('%.0f', places),
    'claims', string.format('%.0f', claims), 'bytes', string.format('%.0f', bytes))
for name in pairs(lost) do
    if not was_found[key(name)] then table.insert(found, key(name)) end
end
notify('work')
return found
