"""Fig. 8 of the paper: true and estimated normal forces, the linkage's mass lumped to the wheels."""

from pathlib import Path

import matplotlib.pyplot as plt
import robhaz

scene = Path(__file__).resolve().parents[2] / "scenes" / "smooth.toml"
run = robhaz.Scene.load(scene, {"estimator": [{"name": "paper-wheels"}]}).run()
truth, estimate = run.truth, run.estimates["paper-wheels"]
figure, axes = plt.subplots(3, sharex=True, sharey=True, figsize=(7, 6), layout="constrained")
for wheel, name, axis in zip((1, 2, 3), ("front", "middle", "rear"), axes):
    force = f"wheel{wheel}_normal_force"
    axis.plot(truth["time"], truth[force], label="truth")
    axis.plot(estimate["time"], estimate[force], label="estimate")
    axis.set_ylabel(f"N, {name} wheel ({truth.units[force]})")
axes[0].legend()
axes[2].set_xlabel("time (s)")
figure.savefig("fig8.png", dpi=150)
print(run)
