// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/executor.h"

namespace ccdt {

namespace {

class InlineExecutor : public Executor {
public:
    void run(std::size_t count, const std::function<void(std::size_t)>& task) override {
        for (std::size_t number = 0; number < count; ++number) task(number);
    }
};

}  // namespace

Executor& inline_executor() {
    static InlineExecutor executor;
    return executor;
}

}  // namespace ccdt
