# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
From the residual of a record to the effect that the model lacks.

1. `prepare` makes an experiment of a record; `data` says what that is, and which blocks of it train
   and test.
2. `hypotheses` are the declared model with effects of the catalogue, or a term without a name.
3. `estimation` fits any of them, and says how sure a parameter is.
4. `selection` says which of them the record calls for, by one comparison (`decide`).
5. `judging` opens the test set, says what is left open, scores the models on another record, cuts
   a record of a valve that changed, and counts how often something is added where nothing is
   missing.

`pipeline` goes through these steps and returns their outcome, a `result`.
"""
