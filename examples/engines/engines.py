"""Rows of balls in other engines: one function for each, which compare.py calls in the environment that it has made.

`engine(module, row, *setting)` sets up a row in the engine's Python module, and returns a function that steps, how
often to call it, and a function that returns the positions (None for engines of rigid bodies) and velocities at the
end. ENGINES has each engine's laws and settings: first the setting that its documentation or its own example of a
cradle recommends, then finer steps and stricter solvers.
"""

import ctypes
import math
import sys
from functools import partial
from itertools import accumulate, pairwise
from pathlib import Path


class Row:
    """A case of exact-rows/cases.json with its fields, in SI units. Free balls begin just at the first contact, and end
    after the last."""

    def __init__(self, case: dict):
        vars(self).update(case)
        self.swing, self.rigid = self.g_over_length, self.law == "restitution"
        self.scale = self.results["v"]["scale"]
        self.exact = {name: [float(x or 0) for x in part["value"]] for name, part in self.results.items()}
        self.reduced = [a * b / (a + b) for a, b in pairwise(self.mass)]
        self.bounce, self.radius = self.damping if self.rigid else 1.0, 1.0
        if not self.rigid:
            # Largest overlap and duration of each contact, if its two balls alone meet at the largest speed.
            p, v, pairs = self.exponent, self.scale, zip(self.stiffness, self.reduced, strict=True)
            self.overlaps = [((p + 1) / 2 * m * v**2 / k) ** (1 / (p + 1)) for k, m in pairs]
            factor = 2 * math.sqrt(math.pi) * math.gamma(1 + 1 / (p + 1)) / math.gamma(0.5 + 1 / (p + 1))
            self.radius = max(100 * max(self.overlaps), *map(abs, self.x))
            # Linear springs with which each contact of two balls alone lasts as long.
            times = [factor * overlap / v for overlap in self.overlaps]
            self.springs = [m * (math.pi / t) ** 2 for m, t in zip(self.reduced, times, strict=True)]
            self.duration = min(times)
            if not self.swing:
                gaps = zip(self.gap, pairwise(self.x), pairwise(self.v), strict=True)
                first = min((gap + b - a) / (v - w) for gap, (a, b), (v, w) in gaps if v > w)
                self.x = [a + b * first for a, b in zip(self.x, self.v, strict=True)]
                self.stop = 1.1 * (max(self.exact["release"]) - first)
        self.rest = [*accumulate(self.gap, lambda at, gap: at + 2 * self.radius + gap, initial=0.0)]
        self.start = [a + b for a, b in zip(self.rest, self.x, strict=True)]
        self.balls = list(zip(self.start, self.mass, self.v, strict=True))

    def steps(self, per_contact: int) -> int:
        """The number of steps of a run with `per_contact` steps in a contact."""
        return math.ceil(self.stop / self.duration * per_contact)

    def rigid_steps(self, step: float) -> tuple[float, int]:
        """Scales a step (s, for balls at 1 m/s) to this row's speed; returns it (s) with the number of steps. In
        engines of rigid bodies compliant contacts are instantaneous, and a second has all of them."""
        return step / self.scale, math.ceil((self.stop * self.scale if self.rigid else 1.0) / step)

    def error(self, places, speeds) -> float:
        """The largest error of velocities and, for pendulums, of displacements times their angular frequency, relative
        to the scale."""
        errors = [abs(v - exact) for v, exact in zip(speeds, self.exact["v"], strict=True)]
        if self.swing:
            found, factor = zip(places, self.rest, self.exact["x"], strict=True), math.sqrt(self.swing)
            errors += [abs((x - rest) * factor - exact * factor) for x, rest, exact in found]
        return max(errors) / self.scale


def mujoco(mj, row: Row, per_contact: int, own: bool = False):
    """Constraints, which act as springs if their impedance is small. `own`: settings of the model newton_cradle.xml
    that comes with MuJoCo, adapted to the row's overlaps and to `per_contact` steps in a contact."""
    pairs, bodies, steps = "", "", row.steps(per_contact)
    for i, (k, m, overlap) in enumerate(zip(row.springs, row.reduced, row.overlaps, strict=True)):
        rate = (row.scale / overlap) ** 2
        solref, solimp = f"{-k / m} {-row.damping / m}", "1e-4 1e-4 1 0.5 1"
        if own:  # force proportional to overlap^5 up to half of the width
            solref, solimp = f"{-21 * rate} {-row.damping / m}", f"0 0.01 {2.3 * overlap} 0.5 2"
        elif row.exponent == 1.5:  # s (0.6 + 0.4 s)^2 is near s^1.5, s = overlap / largest overlap
            solref, solimp = f"{-rate / 0.76} 0", f"6e-4 1e-3 {overlap} 0.5 1"
        pairs += f'<pair geom1="g{i}" geom2="g{i + 1}" condim="1" solref="{solref}" solimp="{solimp}"/>'
    for i, (x, m) in enumerate(zip(row.rest, row.mass, strict=True)):
        bodies += f'<body pos="{x!r} 0 0"><joint type="slide" axis="1 0 0" stiffness="{m * row.swing}"/>'
        bodies += f'<geom name="g{i}" size="{row.radius}" mass="{m}" contype="0" conaffinity="0"/></body>'
    option = f'timestep="{row.stop / steps!r}" gravity="0 0 0" tolerance="0" integrator="{"Euler" if own else "RK4"}"'
    text = f"<option {option}/><worldbody>{bodies}</worldbody><contact>{pairs}</contact>"
    model = mj.MjModel.from_xml_string(f"<mujoco>{text}</mujoco>")
    data = mj.MjData(model)
    data.qpos[:], data.qvel[:] = row.x, row.v
    return lambda: mj.mj_step(model, data, steps), 1, lambda: (data.qpos + row.rest, data.qvel)


def drake(d, row: Row, per_contact: int, accuracy: float = 0.0):
    """Point contacts, k overlap (1 + d der(overlap)), in discrete steps or, with `accuracy`, by error control."""
    builder, step = d.DiagramBuilder(), row.duration / per_contact
    plant, _ = d.AddMultibodyPlantSceneGraph(builder, time_step=0.0 if accuracy else step)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    # Stiffness belongs to balls: 1/k = 1/k1 + 1/k2 for a contact. All contacts get the stiffness of the first.
    contact, friction, stiffness = d.ProximityProperties(), d.CoulombFriction(0.0, 0.0), 2 * row.springs[0]
    d.AddContactMaterial(row.damping, stiffness, friction, contact)
    for i, (x, m) in enumerate(zip(row.rest, row.mass, strict=True)):
        body = plant.AddRigidBody(f"b{i}", d.SpatialInertia.SolidSphereWithMass(m, row.radius))
        joint = plant.AddJoint(d.PrismaticJoint(f"j{i}", plant.world_frame(), body.body_frame(), [1, 0, 0]))
        plant.RegisterCollisionGeometry(body, d.RigidTransform(), d.Sphere(row.radius), f"g{i}", contact)
        if row.swing:
            plant.AddForceElement(d.PrismaticSpring(joint, x, m * row.swing))
    plant.Finalize()
    simulator = d.Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetPositionsAndVelocities(context, [*row.start, *row.v])
    if accuracy:
        solver = {"integration_scheme": "runge_kutta3", "max_step_size": step, "accuracy": accuracy}
        d.ApplySimulatorConfig(d.SimulatorConfig(**solver), simulator)
    simulator.Initialize()
    run, state = simulator.AdvanceTo, plant.GetPositionsAndVelocities
    return lambda: run(row.stop), 1, lambda: state(context).reshape(2, -1)


def lammps(lmp, row: Row, per_contact: int):
    """pair_style granular with velocity Verlet: Hertz or Hooke contacts, damped as viscoelastic spheres or
    Kelvin-Voigt."""
    for mpi in Path(sys.prefix, "lib").glob("libmpi.so.12"):  # of the package mpich, for systems without MPI
        ctypes.CDLL(mpi, ctypes.RTLD_GLOBAL)
    run, r = lmp.lammps(cmdargs=["-screen", "none", "-log", "none"]), row.radius
    wide, steps = 4 * r + abs(row.rest[-1]) + row.stop * row.scale, row.steps(per_contact)
    free = f"tangential linear_nohistory 0 0 damping {'viscoelastic' if row.law == 'viscoelastic' else 'velocity'}"
    limit = "" if row.law == "kelvinVoigt" else "limit_damping"
    run.commands_string(
        f"""units si\natom_style sphere\natom_modify map array\nboundary f f f\ncomm_modify vel yes
        region box block {-wide} {2 * wide} {-2 * r} {2 * r} {-2 * r} {2 * r}\ncreate_box {row.n} box
        neighbor {0.5 * r} bin\nneigh_modify delay 0 every 1\npair_style granular\npair_coeff * * hooke 1 0 {free}"""
    )
    for i, (k, m) in enumerate(zip(row.stiffness, row.reduced, strict=True), start=1):
        hertz = k / math.sqrt(r / 2)
        form = f"hertz {hertz!r}" if row.exponent == 1.5 else f"hooke {k!r}"
        # Viscoelastic spheres: LAMMPS has eta sqrt(R overlap) m where the row has 1.5 A k sqrt(overlap).
        eta = row.damping * (1.5 * hertz / m if row.law == "viscoelastic" else 1.0)
        run.command(f"pair_coeff {i} {i + 1} {form} {eta!r} {free} {limit}")
    for i, (rest, x, m, v) in enumerate(zip(row.rest, row.x, row.mass, row.v, strict=True), start=1):
        spring = f"fix s{i} g{i} spring/self {m * row.swing!r} x" if row.swing else ""
        run.commands_string(
            f"""create_atoms {i} single {rest!r} 0 0\nset type {i} diameter {2 * r!r}\nset type {i} mass {m!r}
            group g{i} type {i}\nvelocity g{i} set {v!r} 0 0\n{spring}\ndisplace_atoms g{i} move {x!r} 0 0"""
        )
    run.commands_string(f"fix 1 all nve/sphere\ntimestep {row.stop / steps!r}\nthermo {steps}\nrun 0")
    go, found = partial(run.command, f"run {steps} pre no post no"), run.numpy.extract_atom
    return go, 1, lambda: [found(name)[found("id").argsort()[: row.n], 0] for name in "xv"]


def exudyn(exu, row: Row, per_contact: int, solver: str):
    """ObjectContactSphereSphere, k overlap^p with damping of Hunt and Crossley, as in its example newtonsCradle.py."""
    from exudyn import utilities as e

    system = exu.SystemContainer().AddSystem()
    ground, node, markers, bodies = system.CreateGround(), exu.NodeType.RotationRxyz, [], []
    for rest, (x, m, v) in zip(row.rest, row.balls, strict=True):
        start = {"referencePosition": [x, 0, 0], "initialVelocity": [v, 0, 0]}
        bodies.append(system.CreateRigidBody(inertia=e.InertiaSphere(m, row.radius), nodeType=node, **start))
        markers.append(system.AddMarker(e.MarkerBodyRigid(bodyNumber=bodies[-1])))
        if row.swing:
            spring = {"localPosition0": [rest, 0, 0], "stiffness": [m * row.swing, 0, 0]}
            system.CreateCartesianSpringDamper(itemNumbers=[ground, bodies[-1]], **spring)
    law = {"contactStiffnessExponent": row.exponent, "contactDamping": row.damping}
    if row.law == "huntCrossley":
        # 1.5 (1 - e) / v times k overlap^p der(overlap); v: the impact's speed, but at least minimumImpactVelocity.
        law |= {"impactModel": 1, "contactDamping": 0.0, "minimumImpactVelocity": 4 * row.scale}
        law |= {"restitutionCoefficient": 1 - row.damping * 4 * row.scale / 1.5}
    for i, k in enumerate(row.stiffness):
        data = system.AddNode(e.NodeGenericData(initialCoordinates=[0.1, 0, 0, 0], numberOfDataCoordinates=4))
        pair = {"markerNumbers": markers[i : i + 2], "nodeNumber": data, "contactStiffness": k}
        system.AddObject(e.ObjectContactSphereSphere(spheresRadii=[row.radius] * 2, **pair, **law))
    system.Assemble()
    settings = exu.SimulationSettings()
    times = settings.timeIntegration
    times.numberOfSteps, times.endTime, times.verboseMode = row.steps(per_contact), row.stop, 0
    times.minimumStepSize, settings.solution.file.write = 1e-9 * row.duration, False
    run = partial(system.SolveDynamic, settings, solverType=getattr(exu.DynamicSolverType, solver))
    kind, read = exu.OutputVariableType, system.GetObjectOutputBody
    return run, 1, lambda: [[read(body, of)[0] for body in bodies] for of in (kind.Position, kind.Velocity)]


def pybullet(p, row: Row, step: float, iterations: int, own: bool = False):
    """Rigid spheres; a pair's coefficient of restitution is the product of its bodies' restitutions. `own`: the
    engine's default correction of overlaps by velocities stays on."""
    step, count = row.rigid_steps(step)
    if p.isConnected():
        p.disconnect()
    p.connect(p.DIRECT)
    p.setPhysicsEngineParameter(step, numSolverIterations=iterations, restitutionVelocityThreshold=0.0)
    if not own:
        p.setPhysicsEngineParameter(contactSlop=1e-12, contactERP=0.0)
    ball, bodies = p.createCollisionShape(p.GEOM_SPHERE, radius=row.radius), []
    for x, m, v in row.balls:
        bodies.append(p.createMultiBody(m, ball, basePosition=[x, 0, 0]))
        p.resetBaseVelocity(bodies[-1], [v, 0, 0])
        free = {"linearDamping": 0, "angularDamping": 0, "lateralFriction": 0}
        p.changeDynamics(bodies[-1], -1, restitution=math.sqrt(row.bounce), **free)
    return p.stepSimulation, count, lambda: (None, [p.getBaseVelocity(body)[0][0] for body in bodies])


def rapier(rp, row: Row, step: float, iterations: int):
    """Rigid spheres in single precision; a pair's coefficient of restitution is the mean of its balls' restitutions."""
    world, bodies, (step, count) = rp.PhysicsWorld(gravity=(0, 0, 0)), [], row.rigid_steps(step)
    world.integration_parameters.dt, world.integration_parameters.num_solver_iterations = step, iterations
    for x, m, v in row.balls:
        ball = rp.Collider.ball(row.radius).restitution(row.bounce).friction(0.0).mass(m)
        body = rp.RigidBody.dynamic(translation=(x, 0, 0)).linvel((v, 0, 0)).can_sleep(False)
        bodies.append(world.add_body(body, colliders=[ball]))
    return world.step, count, lambda: (None, [world.rigid_bodies[body].linvel.x for body in bodies])


def pymunk(pm, row: Row, step: float, iterations: int):
    """Rigid discs; a pair's coefficient of restitution is the product of its shapes' elasticities."""
    space, (step, count) = pm.Space(), row.rigid_steps(step)
    space.iterations = iterations
    for x, m, v in row.balls:
        body = pm.Body(m, pm.moment_for_circle(m, 0, row.radius))
        body.position, body.velocity, shape = (x, 0), (v, 0), pm.Circle(body, row.radius)
        shape.elasticity = math.sqrt(row.bounce)
        space.add(body, shape)
    return lambda: space.step(step), count, lambda: (None, [body.velocity.x for body in space.bodies])


BOUNCES = [(1e-3, 50), (1e-4, 50), (1e-5, 50)]  # step (s, for balls of 1 m at 1 m/s), iterations
ACCURACIES = [(20, 10.0**-k) for k in (3, 6, 9, 12)]  # least number of steps in a contact, accuracy
STEPS = [*((k, "GeneralizedAlpha") for k in (23, 115, 575)), *((k, "RK67") for k in (23, 115, 575, 2875))]
SPHERES = "elastic kelvinVoigt kelvinVoigtNoPull viscoelastic"
ENGINES = {  # module, laws, exponents that are the engine's own, settings
    mujoco: ("mujoco", "elastic kelvinVoigtNoPull", (1.0,), [(12, True), (20,), (100,), (500,), (2500,)]),
    drake: ("pydrake.all", "elastic huntCrossley", (1.0,), [(20,), (100,), *ACCURACIES]),
    lammps: ("lammps", SPHERES, (1.0, 1.5), [(50,), (250,), (1250,), (6250,), (31250,)]),
    exudyn: ("exudyn", "elastic kelvinVoigt huntCrossley", (1.0, 1.5), STEPS),
    pybullet: ("pybullet", "elastic restitution", (), [(1 / 240, 50, True), *BOUNCES]),
    rapier: ("rapier3d", "elastic restitution", (), [(1 / 60, 4), *BOUNCES]),
    pymunk: ("pymunk", "elastic restitution", (), [(1 / 60, 10), *BOUNCES]),
}
