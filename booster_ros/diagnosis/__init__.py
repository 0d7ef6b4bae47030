# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
From the residual of a record to the effect that the model lacks.

1. `preparing` makes an `experiment` of a record.
2. `searching` finds what the model lacks: by `fitting` the model, with effects of the catalogue or
   a term without a name, to parts of the record.
3. `last_fit` fits what was found to all but the locked part; `locked_part` opens the locked part.
4. `diagnose` goes through all these steps and returns their outcome, a `result`.

Beside these, `change` cuts a record of a valve that changed, `validation` scores the models on
another record, `calibration` counts how often something is added where nothing is missing, and
`repeatability` says what is chance.
"""
