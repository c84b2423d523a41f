# ---
# jupyter:
#   jupytext:
#     formats: py:percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # From an empty folder to a prediction and an explanation
#
# A virtual lathe has turned standard cuts with a dynamometer, and two weeks of work without one.
# Their tables ship with autodb, so every cell runs as it is. Open this file as a notebook with
# jupytext, or run it as a program.

# %%
import pandas as pd

import autodb
from autodb.assets import kit

job = kit("sample_jobs") / "stepped_shaft"
db = autodb.open("shop.sqlite3", create=True)
lathe = db.add_machine("lathe-1", job / "machine.toml")

# %% [markdown]
# Standard cuts: currents of the drives, and forces of the dynamometer. Columns are named as
# channels; `columns=` names those of another logger, and `x.current [mA]` states a unit.

# %%
standard_cuts = pd.read_csv(job / "recordings" / "standard-cuts.csv")
lathe.import_(standard_cuts, name="standard-cuts")

# %% [markdown]
# Which axis senses force, and how well on cuts that it was not fitted to?

# %%
calibrated = lathe.calibrate()
calibrated

# %% [markdown]
# A week of work without a dynamometer: currents become forces, forces the pair's parameters.

# %%
lathe.import_(pd.read_csv(job / "recordings" / "shop-week-1.csv"), name="week-1")
for line in lathe.refresh().lines:
    print(line)

# %% [markdown]
# What will the next job take? Each number has a 95 % interval.

# %%
predicted = lathe.predict(job / "job.toml")
predicted.to_pandas()[["name", "force.y", "force.y.low", "force.y.high", "spindle.power"]]

# %%
predicted.plot()

# %% [markdown]
# The second week was harder than predicted. What does the model leave out?

# %%
explained = lathe.explain(pd.read_csv(job / "recordings" / "shop-week-2.csv"), name="week-2")
explained.to_pandas()[["channel", "term", "confidence", "size", "low", "high", "unit"]]

# %%
explained.plot().save("week-2.html")
