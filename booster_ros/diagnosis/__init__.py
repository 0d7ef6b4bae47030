# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
From the residual of a record to the effect that the model lacks.

1. `preparing` makes an `experiment` of a record.
2. `searching` finds what the model lacks by `fitting` it, with effects of the catalogue or a term
   without a name, to parts of the record.
3. `last_fit` fits what was found to all but the locked part, `locked_part` opens that.
4. `diagnose` goes through all this and says what came of it: a `result`.

Beside it: `change` cuts a record of a valve that changed, `validation` scores on another record,
`calibration` counts how often something is added where nothing is missing, `repeatability` says
what is chance.
"""
