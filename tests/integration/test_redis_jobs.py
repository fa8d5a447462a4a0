# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs that a server keeps in Redis."""

import unittest

import test_jobs
from engine import Redis


class JobsByRedis(test_jobs.Jobs):
    """Runs all tests of jobs, with jobs kept by Redis."""

    @classmethod
    def setUpClass(cls):
        cls.redis = Redis()
        cls.addClassCleanup(cls.redis.__exit__)
        cls.flags = ("--workers=2", f"--redis={cls.redis.url}")
        super().setUpClass()


if __name__ == "__main__":
    unittest.main(verbosity=2)
