# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares answers of the WebAssembly module and of the server to some of the random requests of wasm_fuzz.py."""

import collections
import unittest

import test_wasm
import wasm_fuzz
from harness import Server

SEED, NUMBERS = 1, range(100)


@unittest.skipUnless(test_wasm.MODULE.exists(), "the module is not built")
class WasmFuzz(unittest.TestCase):
    def test_answers_random_requests_as_the_server_does(self):
        counts = collections.Counter()
        with Server() as server:
            for number, request, expected, answer in wasm_fuzz.differences(server, SEED, NUMBERS, counts):
                with self.subTest(number=number, request=request):
                    self.assertEqual((answer.status, answer.body), (expected.status, expected.body))
        self.assertGreater(counts[200], len(NUMBERS) / 3, counts)


if __name__ == "__main__":
    unittest.main(verbosity=2)
