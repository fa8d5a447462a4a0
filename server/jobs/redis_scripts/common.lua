-- What all scripts share. Keys, after the prefix that KEYS[1] is:
--
--   job:ID       hash   all that is known of a job but its bodies
--   question:ID  hash   path, query, content_type, accept, size of the body, and the body in pieces: 0, 1 and so on
--   result:ID    hash   the result in pieces
--   queue        zset   places of the jobs that wait, by turn; a place is a number of 16 digits, then the id
--   had          zset   clients, by what they will have had: start-time fair queuing, as in fair_queue.h
--   waiting      hash   clients, and how many of their jobs wait
--   leases       zset   ids of the jobs that are claimed, by when their leases run out
--   finished     zset   ids of the jobs that have ended, by when they did in microseconds
--   results      zset   those of them that have a result
--   state        hash   turn: that was taken last; places, claims: numbers given; bytes: that are kept
--   news         channel: `work`, `changed ID`, `stop ID`

local prefix = KEYS[1]
local time = redis.call('TIME')
local exact_now = time[1] * 1000000 + time[2]    -- microseconds
local now = math.floor(exact_now / 1000)         -- milliseconds

local function key(name) return prefix .. name end
local function job_key(id) return prefix .. 'job:' .. id end
local function question_key(id) return prefix .. 'question:' .. id end
local function result_key(id) return prefix .. 'result:' .. id end

local function tell(news) redis.call('PUBLISH', key('news'), news) end

local function state(name) return tonumber(redis.call('HGET', key('state'), name) or '0') end

local function field(id, name) return redis.call('HGET', job_key(id), name) end

local function is_full(client, most)
    local waiting = redis.call('ZCARD', key('queue'))
    if waiting < most then return false end
    return waiting >= 2 * most or redis.call('HEXISTS', key('waiting'), client) == 1
end

-- Puts a body where it belongs: one that was uploaded before, or the fields of one that came with the call.
local function put(body_key, uploaded, fields)
    if uploaded == '' then
        redis.call('HSET', body_key, unpack(fields))
    else
        redis.call('RENAME', uploaded, body_key)
        redis.call('PERSIST', body_key)
    end
end

local function discard(uploaded)
    if uploaded ~= '' then redis.call('UNLINK', uploaded) end
end

-- Changes what a job counts for.
local function set_bytes(id, bytes)
    local before = tonumber(field(id, 'bytes') or '0')
    redis.call('HINCRBY', key('state'), 'bytes', bytes - before)
    redis.call('HSET', job_key(id), 'bytes', bytes)
end

local function enter_queue(id, turn, place)
    redis.call('ZADD', key('queue'), turn, place)
    redis.call('HINCRBY', key('waiting'), field(id, 'client'), 1)
    redis.call('HSET', job_key(id), 'place', place)
    tell('work')
end

-- Returns the turn that a job had, or nothing if it did not wait.
local function leave_queue(id)
    local place = field(id, 'place')
    local turn = place and redis.call('ZSCORE', key('queue'), place)
    if not turn then return nil end
    redis.call('ZREM', key('queue'), place)
    local client = field(id, 'client')
    if redis.call('HINCRBY', key('waiting'), client, -1) <= 0 then redis.call('HDEL', key('waiting'), client) end
    return tonumber(turn)
end

-- Returns the memory that the job at a place takes, or nothing if there is no whole job: others than these scripts may
-- have deleted keys, as a Redis does that drops what was not asked for.
local function memory_at(id, place)
    local known = redis.call('HMGET', job_key(id), 'place', 'client', 'memory', 'seconds')
    return known[1] == place and known[2] and tonumber(known[4]) and tonumber(known[3])
end

-- Once nobody waits all that was had is forgotten.
local function forget_turns_if_empty()
    if redis.call('EXISTS', key('queue')) == 1 then return end
    redis.call('DEL', key('had'), key('waiting'))
    redis.call('HDEL', key('state'), 'turn')
end

-- Has a claimed job wait again, first of all.
local function put_back(id)
    redis.call('ZREM', key('leases'), id)
    if not memory_at(id, field(id, 'place')) then return end
    redis.call('HSET', job_key(id), 'status', 'queued', 'fraction', 0, 'iteration', 0)
    redis.call('HDEL', job_key(id), 'started', 'variation')
    enter_queue(id, math.min(tonumber(field(id, 'turn') or '0'), state('turn')), field(id, 'place'))
    tell('changed ' .. id)
end

-- Takes a job from where it waits, or from whoever has claimed it.
local function withdraw(id)
    redis.call('ZREM', key('leases'), id)
    if leave_queue(id) then
        local client = field(id, 'client')
        if redis.call('ZSCORE', key('had'), client) then
            redis.call('ZINCRBY', key('had'), -tonumber(field(id, 'seconds')), client)
        end
        forget_turns_if_empty()
    end
end

local function remove(id)
    withdraw(id)
    set_bytes(id, 0)
    redis.call('ZREM', key('finished'), id)
    redis.call('ZREM', key('results'), id)
    redis.call('UNLINK', job_key(id), question_key(id), result_key(id))
end

-- Drops the oldest results, and then what is left of the jobs that ended first, until there is room.
local function make_room(bytes, most)
    while state('bytes') + bytes > most do
        local dropped = redis.call('ZPOPMIN', key('results'))[1]
        local oldest = not dropped and redis.call('ZRANGE', key('finished'), 0, 0)[1]
        if dropped then
            redis.call('UNLINK', result_key(dropped))
            local bytes, of_result = tonumber(field(dropped, 'bytes')), tonumber(field(dropped, 'result_bytes'))
            if bytes and of_result then
                redis.call('HSET', job_key(dropped), 'dropped', 1)
                set_bytes(dropped, bytes - of_result)
            end
        elseif oldest then
            remove(oldest)
        else
            return false
        end
    end
    return true
end

-- Whether a claim is the latest, and its lease has not been taken by another.
local function owns(id, claim)
    return field(id, 'claim') == claim and redis.call('ZSCORE', key('leases'), id) ~= false
end

local function expired(id, ttl)
    local finished = field(id, 'finished')
    return finished and tonumber(finished) + tonumber(ttl) <= now
end
