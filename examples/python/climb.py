"""Design search for a linkage that climbs stairs, as geometry C was found: docs/climbing.md. With the package robhaz
(docs/python.md), SciPy and for `figure` matplotlib:

    python examples/python/climb.py search --seed 1 --out geometry.toml
    python examples/python/climb.py table A C geometry.toml
    python examples/python/climb.py figure climbing.png A C

A GEOMETRY is a built-in name or the path of a .toml file. Points are complex numbers x + iy in the nominal pose, m.
"""

import argparse
import tomllib
from pathlib import Path

import numpy as np
import robhaz
from scipy.optimize import differential_evolution

STAIRS = Path(__file__).resolve().parents[2] / "scenes" / "stairs.toml"
# What is searched, and its bounds, m. Spacings: wheels are at least 20 mm apart. Pins: within the robot, at least 40 mm
# above the ground. The body's centre of mass is not lower than that of geometry A: its box is above the wheels there.
VARIABLES = {"front axle ahead of the middle one": (0.22, 0.42), "rear axle behind the middle one": (0.22, 0.42),
             "P, x": (-0.05, 0.40), "P, y": (0.10, 0.35), "Q, x": (-0.20, 0.25), "Q, y": (0.04, 0.25),
             "R, x": (-0.42, 0.05), "R, y": (0.08, 0.30), "S, x": (-0.42, 0.15), "S, y": (0.15, 0.40),
             "body's centre of mass, x": (-0.15, 0.15), "body's centre of mass, y": (0.30, 0.36)}
LOW, HIGH = np.transpose(list(VARIABLES.values()))
# Constraints: most spread of the static loads over their mean; least height that the front wheel can be lifted inside
# the stops, m; least distance of neighbouring pins, twice the width of a bar, m; least sine of the angle between body
# and link3 at pin S, whose forces grow without bound towards 0.
LOAD_SPREAD, REACH, SHORTEST_BAR, LEAST_SINE = 0.15, 0.18, 0.06, 0.26
# Violation of a geometry without static loads.
UNDETERMINED = 20.0
# Margins that a drive keeps: clearance of body and links, m; pin Q to its end stops, rad.
LEAST_CLEARANCE, LEAST_STOP_MARGIN = 0.005, 0.035
# A robot is stuck when it has not come so much farther, m, in so long, s. Longest drive, s, and its start, s.
FARTHER, PATIENCE, LONGEST, START_TIME = 0.005, 3.0, 40.0, 0.8
CONTROLS = {"speed, PI": {}, "speed, soft": {"drive.kp": 2, "drive.ki": 0},
            "shared": {"drive.kind": "shared", "sensors.grade": "typical", "sensors.rate": 1000}}
# The trials from easy to hard: control, mu_s, riser (m), tread (m).
TRIALS = [("PI", 1.00, 0.08, 0.30), ("PI", 0.80, 0.08, 0.30), ("soft", 0.80, 0.08, 0.30), ("PI", 0.80, 0.08, 0.32),
          ("PI", 0.70, 0.08, 0.30), ("soft", 0.70, 0.08, 0.30), ("PI", 0.65, 0.08, 0.28), ("PI", 0.60, 0.08, 0.30),
          ("soft", 0.60, 0.08, 0.30), ("PI", 0.80, 0.10, 0.30), ("PI", 0.55, 0.08, 0.30), ("soft", 0.55, 0.08, 0.30),
          ("PI", 0.50, 0.08, 0.30), ("soft", 0.50, 0.08, 0.30), ("PI", 0.50, 0.08, 0.32), ("PI", 0.45, 0.08, 0.30),
          ("soft", 0.45, 0.08, 0.30), ("PI", 0.80, 0.12, 0.30), ("PI", 0.40, 0.08, 0.30), ("soft", 0.40, 0.08, 0.30),
          ("PI", 0.35, 0.08, 0.30), ("PI", 0.30, 0.08, 0.30)]


def resolved(geometry):
    """A geometry, by its name, file or table, and the masses `caption`, with all defaults: as in the scene of a run."""
    if str(geometry).endswith(".toml"):
        geometry = str(Path(geometry).resolve())
    return tomllib.loads(robhaz.Scene.load(STAIRS, {"robot.geometry": geometry}).to_toml())["robot"]


A = resolved("A")


def design(x):
    """The geometry of a point of the search, on whole millimetres; wheels, carriers and end stops are those of A."""
    front, rear, *points = np.round(x, 3).tolist()
    radius = A["geometry"]["wheel_radius"]
    return {"wheel_radius": radius, "axles": [[front, radius], [0.0, radius], [-rear, radius]],
            "carriers": A["geometry"]["carriers"], "body_cg": points[8:], "stop": A["geometry"]["stop"],
            "pins": {pin: points[2 * i : 2 * i + 2] for i, pin in enumerate("pqrs")}}


def points(geometry):
    """Axles, pins by their letters, and the body's centre of mass."""
    pins = {pin: complex(*at) for pin, at in geometry["pins"].items()}
    return [complex(*axle) for axle in geometry["axles"]], pins, complex(*geometry["body_cg"])


def cross(a, b):
    return (np.conj(a) * b).imag


def static_loads(geometry):
    """Normal forces at rest on level ground, N, by virtual work: the robot is raised, or link1 or link2 turns about Q
    while body and link3 follow. Raises `numpy.linalg.LinAlgError` where they are not determined."""
    (front, middle, rear), pins, body_cg = points(geometry)
    p, q, r, s = (pins[pin] for pin in "pqrs")
    mass, wheel = A["mass"], A["mass"]["wheel"]
    # Rates of body and link3 for a unit rate of each link, from the closed loop.
    c, d, det = s - p, s - r, -cross(s - p, s - r)
    body, link3 = [cross(p - q, d) / det, -cross(r - q, d) / det], [-cross(c, p - q) / det, cross(c, r - q) / det]
    # Each link's centre of mass is the mean of its own pins and axles.
    own = [mass["links"][0] * ((p + q + front) / 3 - q), mass["links"][1] * ((q + r + middle + rear) / 4 - q)]
    wheels = [[front - q, 0, 0], [0, middle - q, rear - q]]
    work = [mass["body"] + sum(mass["links"]) + 3 * wheel]
    for i in range(2):
        of_body = (p - q) * (i == 0) + body[i] * (body_cg - p)
        of_link3 = (r - q) * (i == 1) + link3[i] * ((r + s) / 2 - r)
        work.append((own[i] + mass["body"] * of_body + mass["links"][2] * of_link3 + wheel * sum(wheels[i])).real)
    return np.linalg.solve([[1, 1, 1], *np.real(wheels)], 9.81 * np.array(work))


def reach(geometry):
    """Height that the front wheel can be lifted inside the stops while the others stand on level ground, m."""
    (front, middle, _), pins, _ = points(geometry)
    turned = (front - pins["q"]) * np.exp(1j * angles(geometry)) + pins["q"] - middle
    return max(0, *turned.imag[sines(geometry) >= 0])


def angles(geometry):
    """Angles of pin Q from one end stop to the other, rad."""
    return np.linspace(geometry["stop"]["lower"], geometry["stop"]["upper"], 16)


def sines(geometry):
    """Sine of the angle between body and link3 at these angles, by the law of cosines; -1 where the loop is open."""
    _, pins, _ = points(geometry)
    p, q, r, s = (pins[pin] for pin in "pqrs")
    body, link3, base = abs(s - p), abs(s - r), abs((p - q) * np.exp(1j * angles(geometry)) - (r - q))
    cosine = (body**2 + link3**2 - base**2) / (2 * body * link3)
    return np.where(abs(cosine) <= 1, np.sqrt(1 - np.minimum(cosine**2, 1)), -1)


def violation(geometry):
    """How far a geometry is from meeting all constraints; 0 where it meets them. Without a unit: it only leads."""
    _, pins, _ = points(geometry)
    p, q, r, s = (pins[pin] for pin in "pqrs")
    bars = np.abs([p - q, q - r, r - s, s - p])
    if min(bars) == 0 or cross(s - p, s - r) == 0:
        return UNDETERMINED
    try:
        loads = static_loads(geometry)
    except np.linalg.LinAlgError:
        return UNDETERMINED
    return (np.clip(np.ptp(loads) / abs(loads.mean()) - LOAD_SPREAD, 0, 5) + (loads.min() <= 0)
            + 10 * np.maximum(SHORTEST_BAR - bars, 0).sum() + 10 * max(REACH - reach(geometry), 0)
            + np.maximum(LEAST_SINE - sines(geometry), 0).sum())


def drive(geometry, control, mu, rise, tread):
    """One drive up four risers, engine `direct`. Returns how it ended (`passed`, `stuck`, `no margin`, `broke off`),
    the share of the way, the least angle to an end stop (rad), the least clearance (m), and the truth.

    It passes when the rear wheel is 150 mm behind the last riser. A robot that overturns or folds has done no way.
    """
    keys = {"robot.geometry": geometry, "engine.kind": "direct", "contact.mu_s": mu, "contact.mu_d": 0.875 * mu,
            "terrain.rise": rise, "terrain.run": tread, "drive.start_time": START_TIME, "sensors.rate": 100,
            "record.rate": 100, "estimator": [{"name": "kalman", "contact_angles": "none"}], **CONTROLS[control]}
    goal = 0.7 + 3 * tread - geometry["axles"][2][0] + 0.15
    # Most drives end in 15 s.
    for duration in (15, LONGEST):
        try:
            truth = robhaz.Scene.load(STAIRS, keys | {"record.duration": duration}).run().truth
        except (robhaz.RunError, robhaz.SceneError):
            return "broke off", 0.0, 0.0, 0.0, None
        opening = truth["link1_angle"] - truth["link2_angle"]
        stop = np.minimum(geometry["stop"]["upper"] - opening, opening - geometry["stop"]["lower"])
        stop, clear = np.minimum.accumulate(stop), np.fmin.accumulate(truth["clearance"])
        best, since = -np.inf, START_TIME
        for i, (time, x) in enumerate(zip(truth["time"], truth["wheel2_x"])):
            if x > best + FARTHER:
                best, since = x, max(time, START_TIME)
            if clear[i] < LEAST_CLEARANCE or stop[i] < LEAST_STOP_MARGIN:
                end = "no margin"
            elif x >= goal:
                end = "passed"
            elif time - since > PATIENCE or time >= LONGEST - 0.01:
                end = "stuck"
            else:
                continue
            return end, np.clip(truth["wheel2_x"][: i + 1].max() / goal, 0, 1), stop[i], clear[i], truth
    return "stuck", np.clip(best / goal, 0, 1), stop[-1], clear[-1], truth


def passes(*trial):
    return drive(*trial)[0] == "passed"


def cost(x):
    """Minus the number of trials that a design passes before its first failure, and minus the share of the way in that
    one. A design that breaks a constraint costs more than all that break none."""
    geometry = design(x)
    if (found := violation(geometry)) > 0:
        return 1 + found
    climbed = 0.0
    for control, *stairs in TRIALS:
        end, share, *_ = drive(geometry, f"speed, {control}", *stairs)
        if end != "passed":
            return -(climbed + min(share, 0.999))
        climbed += 1
    return -climbed


def search(asked):
    """Differential evolution from uniform draws that meet all constraints; 0.6 % of the draws do. The same seed gives
    the same design on any number of processes."""
    random = np.random.default_rng(asked.seed)
    first = []
    while len(first) < max(asked.population, 5):
        x = random.uniform(LOW, HIGH)
        if violation(design(x)) <= 0:
            first.append(x)

    def tell(intermediate_result):
        best = intermediate_result
        print(f"generation {best.nit}: {-best.fun:.3f} of {len(TRIALS)} trials", flush=True)

    found = differential_evolution(
        cost, list(zip(LOW, HIGH)), init=np.array(first), strategy="randtobest1bin", mutation=(0.4, 0.9),
        recombination=0.9, maxiter=asked.generations, tol=0, polish=False, rng=random, updating="deferred",
        workers=asked.jobs, callback=tell)
    geometry = design(found.x)
    command = f"--seed {asked.seed} --population {asked.population} --generations {asked.generations}"
    lines = [f"# climb.py search {command}: passes {-found.fun:.2f} of {len(TRIALS)} trials"]
    lines += [f"{name} = {geometry[name]}" for name in ("wheel_radius", "axles", "carriers", "body_cg")]
    for part in ("pins", "stop"):
        lines += ["", f"[{part}]", *(f"{name} = {value}" for name, value in geometry[part].items())]
    asked.out.write_text("\n".join([*lines, ""]))
    print(f"{found.nfev} designs; the best one passes {-found.fun:.2f} of {len(TRIALS)} trials: {asked.out}")


def least_mu(geometry, control, rise):
    """The last mu_s before the first failure, in steps of 0.02 from 1.2 down; None if it fails at 1.2."""
    least = None
    for mu in np.round(np.arange(1.2, 0.02, -0.02), 2):
        if not passes(geometry, control, mu, rise, 0.3):
            break
        least = mu
    return least


def table(asked):
    """Prints what geometries reach."""
    for name in asked.geometry:
        geometry = resolved(name)["geometry"]
        loads = static_loads(geometry)
        print(f"{name}: static loads {loads.round(2)} N, reach {reach(geometry):.3f} m\n")
        print("| control | least mu_s, 80 mm | highest riser, mu_s 0.8, mm | to a stop, deg | clearance, mm | end |")
        print("|---|---|---|---|---|---|")
        for control in CONTROLS:
            end, _, stop, clear, _ = drive(geometry, control, 0.8, 0.08, 0.3)
            rises = [5 * k for k in range(1, 41)]
            failed = next((k for k in rises if not passes(geometry, control, 0.8, k / 1e3, 0.3)), 205)
            print(f"| {control} | {least_mu(geometry, control, 0.08)} | {failed - 5} | {np.degrees(stop):.1f} "
                  f"| {1e3 * clear:.0f} | {end} |", flush=True)


def draw(axis, geometry, truth=None, at=0, names=False):
    """A robot, at a row of the truth or in the nominal pose."""
    axles, pins, body_cg = points(geometry)
    low, high = (complex(*geometry["outline"][f"body_{end}"]) - body_cg for end in ("lower", "upper"))
    pitch = 0.0
    if truth is not None:
        axles = [complex(truth[f"wheel{i}_x"][at], truth[f"wheel{i}_y"][at]) for i in (1, 2, 3)]
        pins = {pin: complex(truth[f"pin_{pin}_x"][at], truth[f"pin_{pin}_y"][at]) for pin in "pqrs"}
        body_cg, pitch = complex(truth["body_x"][at], truth["body_y"][at]), truth["body_pitch"][at]
    box = np.array([low, high.real + 1j * low.imag, high, low.real + 1j * high.imag, low])
    box = box * np.exp(1j * pitch) + body_cg
    for axle in axles:
        rim = axle + geometry["wheel_radius"] * np.exp(2j * np.pi * np.linspace(0, 1, 61))
        axis.plot(rim.real, rim.imag, color="#b4b4b4")
    p, q, r, s = (pins[pin] for pin in "pqrs")
    # Colours of Okabe and Ito: body, link1, link2, link3.
    bars = [(box, "#555555"), ([p, s], "#555555"), ([axles[0], p, q], "#d55e00"), ([r, s], "#009e73"),
            ([q, axles[1], r, axles[2]], "#0072b2")]
    for bar, colour in bars:
        axis.plot(np.real(bar), np.imag(bar), color=colour, linewidth=1.5 if bar is box else 3)
    axis.plot([pin.real for pin in pins.values()], [pin.imag for pin in pins.values()], "ko", markersize=4)
    for pin, at in pins.items() if names else []:
        axis.annotate(pin.upper(), (at.real, at.imag), (3, 6), textcoords="offset points")


def figure(asked):
    """The last geometry on the stairs and in the nominal pose; the least mu_s of all over the height of the riser."""
    from matplotlib.figure import Figure

    robots = {name: resolved(name)["geometry"] for name in asked.geometry}
    last, geometry = list(robots.items())[-1]
    picture = Figure(figsize=(13.2, 9), layout="constrained")
    top, left, right = picture.subplot_mosaic([["top", "top"], ["left", "right"]]).values()
    truth = drive(geometry, "speed, PI", 0.8, 0.08, 0.3)[-1]
    top.stairs([0, 0.08, 0.16, 0.24, 0.32], [-0.6, 0.7, 1, 1.3, 1.6, 2.75], baseline=None, color="black")
    for x in (0, 1.05, 2.1):
        draw(top, geometry, truth, int(np.argmax(truth["wheel2_x"] >= x)))
    draw(left, geometry, names=True)
    for axis, on in ((top, " on stairs of 80 mm, mu_s = 0.8, speed control PI"), (left, "")):
        axis.set(title=f"Geometry {Path(last).stem}{on}", xlabel="x, m", ylabel="y, m", aspect="equal")
    rises = np.array([30, 40, 60, 80, 100, 120])
    for name, geometry in robots.items():
        for control in ("speed, PI", "speed, soft"):
            least = [least_mu(geometry, control, rise / 1e3) or np.nan for rise in rises]
            right.plot(rises, least, "o-", markerfacecolor="none", label=f"{Path(name).stem}, {control}")
    right.set(title="Least friction coefficient that climbs", xlabel="riser, mm (tread 300 mm)", ylabel="mu_s")
    right.axis((20, 130, 0, 1.25))
    right.grid(color="#e0e0e0")
    right.legend()
    picture.savefig(asked.out, dpi=100)
    print(f"Figure: {asked.out}")


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("search", help="searches a geometry and writes it as a file")
    command.add_argument("--seed", type=int, default=1)
    command.add_argument("--population", type=int, default=40)
    command.add_argument("--generations", type=int, default=60)
    command.add_argument("--jobs", type=int, default=-1, help="processes; all processors by default")
    command.add_argument("--out", type=Path, required=True, help="the .toml file")
    command.set_defaults(run=search)
    for run in (table, figure):
        command = commands.add_parser(run.__name__, help=run.__doc__)
        if run is figure:
            command.add_argument("out", type=Path, help="the picture: .svg, .png or .pdf")
        command.add_argument("geometry", nargs="+", help="a built-in name such as A, or the path of a .toml file")
        command.set_defaults(run=run)
    asked = parser.parse_args(arguments)
    try:
        asked.run(asked)
    except robhaz.SceneError as error:
        parser.exit(1, f"{error}\n")


if __name__ == "__main__":
    main()
