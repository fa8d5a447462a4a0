// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/fetch/fetch.h"

#include <gtest/gtest.h>
#include <netdb.h>

#include <chrono>
#include <future>
#include <memory>
#include <string>

#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

using std::chrono::milliseconds;

/// A fetch from a host whose look-up does not end before `end()`.
class SlowLookup {
public:
    ~SlowLookup() { end(); }

    HttpResult<std::string> fetch(milliseconds timeout, const std::function<bool()>& given_up) {
        const auto resolve = [ended = ended_.get_future().share()](auto&&...) {
            ended.wait();
            return EAI_AGAIN;
        };
        const auto slot = std::make_shared<int>();
        slot_ = slot;
        return server::fetch("http://slow.test/a.png", *TargetHosts::parse("http://slow.test"),
                             {.max_bytes = 1, .timeout = timeout}, {}, given_up, slot, resolve);
    }

    bool holds_slot() const { return !slot_.expired(); }

    void end() {
        if (!has_ended_) ended_.set_value();
        has_ended_ = true;
    }

private:
    std::promise<void> ended_;
    bool has_ended_ = false;
    std::weak_ptr<int> slot_;
};

TEST(Fetch, LimitsTheTimeOfLookups) {
    SlowLookup lookup;
    const auto fetched = lookup.fetch(milliseconds(50), [] { return false; });
    ASSERT_FALSE(fetched);
    EXPECT_EQ(fetched.error().status, 422);
    EXPECT_EQ(fetched.error().error.message, "image_url: the host took too long");
}

TEST(Fetch, EndsDuringLookupIfTheFileIsNoLongerWanted) {
    SlowLookup lookup;
    int calls = 0;
    const auto fetched = lookup.fetch(test::kPatience, [&] { return ++calls > 2; });
    ASSERT_FALSE(fetched);
    EXPECT_EQ(fetched.error().error.message, "image_url: the file is no longer wanted");
}

TEST(Fetch, KeepsItsSlotUntilTheLookupEnds) {
    SlowLookup lookup;
    EXPECT_FALSE(lookup.fetch(milliseconds(1), [] { return false; }));
    EXPECT_TRUE(lookup.holds_slot());
    lookup.end();
    EXPECT_TRUE(test::wait_until("the end of the look-up", [&] { return !lookup.holds_slot(); }));
}

}  // namespace
}  // namespace ccdt::server
