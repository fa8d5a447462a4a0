// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/decoder/decoder_confinement.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <string>

namespace ccdt::server {
namespace {

TEST(Confinement, DescribesActiveLayers) {
    Confinement confinement;
    confinement.user = 65534;
    EXPECT_TRUE(confinement.is_whole());
    EXPECT_EQ(confinement.describe(),
              "pictures are decoded by user 65534; in force: no root, no capabilities, network namespace, mount "
              "namespace, empty root directory, pid namespace, ipc namespace, uts namespace, Landlock, system call "
              "filter");
}

TEST(Confinement, DescribesMissingLayersWithTheirErrors) {
    Confinement confinement;
    confinement.errors.fill(EPERM);
    confinement.error(Layer::Capabilities) = 0;
    confinement.error(Layer::Landlock) = ENOSYS;
    EXPECT_FALSE(confinement.is_whole());
    EXPECT_TRUE(confinement.has(Layer::Capabilities));
    EXPECT_FALSE(confinement.has(Layer::User));
    const std::string told = confinement.describe();
    EXPECT_TRUE(
        told.starts_with("pictures are decoded by user 0; in force: no capabilities; not in force: no root "
                         "(Operation not permitted), network namespace (Operation not permitted), "))
        << told;
    EXPECT_TRUE(told.ends_with("Landlock (Function not implemented), system call filter (Operation not permitted)"));
}

}  // namespace
}  // namespace ccdt::server
