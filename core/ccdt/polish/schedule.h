// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <stop_token>

#include "core/ccdt/polish/settings.h"

namespace ccdt {

/// Parameters of a push that moves near sites apart; see PolishSettings.
struct Push {
    double reach = 0, push = 0;          ///< between sites of one ink
    double ink_reach = 0, ink_push = 0;  ///< between sites of different inks
};

/// Runs rounds of a polish until stopped.
/// @param round  called with the number of the round, from 0
/// @param after  called after each round that was not stopped; may be empty
template <class Round>
void repeat(int rounds, const std::stop_token& stop, const std::function<void()>& after, Round&& round) {
    for (int i = 0; i < rounds && !stop.stop_requested(); ++i) {
        round(i);
        if (after && !stop.stop_requested()) after();
    }
}

/// Runs all rounds of a polish in the order of the settings.
///
/// @param steps  performs the steps: push(Push), equalise(passes), even_out(), which evens out each ink,
///               even_out_together(), restore(), which makes the meshes Delaunay, is_any_nearer(least),
///               separate(least), which relocates one site of each pair that is_any_nearer() found, retouch(), and
///               remove_low_frequencies()
/// @param after  called after each round that was not stopped; may be empty
template <class Steps>
void run_schedule(const PolishSettings& settings, Steps&& steps, const std::stop_token& stop,
                  const std::function<void()>& after) {
    constexpr double kNearPush = 0.5;  // each of the two sites moves half of the missing distance
    const Push far{settings.reach, settings.push, settings.ink_reach, settings.push};
    const Push near{settings.nearest, kNearPush, settings.ink_nearest, settings.push};
    repeat(settings.rounds, stop, after, [&](int round) {
        if (settings.mesh_every > 0 && round > 0 && round % settings.mesh_every == 0) steps.restore();
        steps.push(far);
        if ((round + 1) % settings.even_every == 0) steps.even_out();
    });
    repeat(settings.relax_rounds, stop, after, [&](int) {
        if (settings.relax_pushes) steps.push(far);
        for (int even = 0; even < settings.relax_evens; ++even) steps.even_out();
        steps.equalise(settings.relax_passes);
    });
    repeat(settings.even_rounds, stop, after, [&](int) {
        steps.even_out_together();
        steps.even_out();
        for (int push = 0; push < settings.near_pushes_per_even_round; ++push) steps.push(near);
    });
    repeat(settings.near_rounds, stop, after, [&](int) { steps.push(near); });
    // Near pushes are repeated on new triangulations while any two sites are too near. Pushes cannot separate two sites
    // that are enclosed by other sites or by the border in a narrow neck. One of two such sites is relocated.
    const auto push_until_apart = [&] {
        for (int round = 0;
             round < settings.max_retries && !stop.stop_requested() && steps.is_any_nearer(settings.least); ++round) {
            if (round >= settings.relocate_after) steps.separate(settings.least);
            steps.restore();
            steps.push(near);
        }
    };
    push_until_apart();
    repeat(settings.last_rounds, stop, after, [&](int) {
        steps.even_out();
        push_until_apart();
    });
    repeat(settings.retouch_rounds, stop, after, [&](int) { steps.retouch(); });
    repeat(settings.stealth_rounds, stop, after, [&](int) { steps.remove_low_frequencies(); });
}

}  // namespace ccdt
