//! Bad input through the C functions: each gives an error that names the fault and what is allowed, and leaves the
//! instance usable.

use std::fs;
use std::ptr::{null, null_mut};

use cradle_host::{Host, Instantiate, fmi2Error, fmi2OK, guid, resources};
use newtons_cradle::fmi2::*;
use newtons_cradle::variables::{FILE_NAME, Recipe, StartValue};

#[test]
fn bad_parameters_are_refused_with_their_ranges() {
    let host = Host::default();
    let bad = [
        ("ball.mass", 0.0, "ball.mass = 0 kg is refused; allowed: finite and > 0 kg"),
        ("ball.mass", -1.0, "ball.mass = -1 kg is refused; allowed: finite and > 0 kg"),
        ("ball.mass", f64::NAN, "ball.mass = NaN kg is refused"),
        ("ball.massRatio[3]", f64::INFINITY, "ball.massRatio[3] = inf is refused"),
        ("x_start[2]", f64::NEG_INFINITY, "x_start[2] = -inf m is refused; allowed: any finite value m"),
        ("contact.exponent", 0.5, "contact.exponent = 0.5 is refused; allowed: 1 to 10"),
        ("contact.exponent", 10.5, "contact.exponent = 10.5 is refused; allowed: 1 to 10"),
        ("ball.poissonRatio", 0.6, "ball.poissonRatio = 0.6 is refused; allowed: 0 to 0.5"),
        ("gravity", -9.81, "gravity = -9.81 m/s2 is refused; allowed: finite and >= 0 m/s2"),
        ("solver.tolerance", 0.1, "solver.tolerance = 0.1 is refused; allowed: 1e-14 to 0.001"),
        ("solver.fixedStep", 0.0, "solver.fixedStep = 0 s is refused; allowed: finite and > 0 s"),
        ("F_ext[1]", f64::NAN, "F_ext[1] = NaN N is refused"),
    ];
    for (name, value, expected) in bad {
        host.refused(host.set(name, value), &format!("fmi2SetReal: {expected}"));
    }
    let expected = "contact.dampingLaw = 99 is refused; allowed: kelvinVoigt (1) or kelvinVoigtNoPull (2) or \
                    huntCrossley (3) or viscoelastic (4) or constantRestitution (5)";
    host.refused(host.set("contact.dampingLaw", 99.0), expected);
    host.assert_usable();
}

#[test]
fn bad_starts_of_rigid_balls_are_refused() {
    let host = Host::default();
    host.refused(host.set("contact.restitution", 1.1), "contact.restitution = 1.1 is refused; allowed: 0 to 1");
    host.give("contact.model=rigid x_start[3]=0.001");
    assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
    host.refused(host.exit(), "rigid balls 3 and 4 overlap by 9.9740e-4 m; allowed: x_start[3] - x_start[4]");
    // Still in Initialization Mode: it can be corrected.
    host.give("x_start[3]=0 solver.method=bdf");
    let expected = "contact.model = rigid has no contact force that solver.method could integrate; allowed with it: \
                    eventDriven (1)";
    host.refused(host.exit(), expected);
    assert_eq!((host.set("solver.method", 1.0), host.exit(), host.step(0.0, 1.0)), (fmi2OK, fmi2OK, fmi2OK));
    host.assert_usable();
}

#[test]
fn bad_starts_beyond_the_range_of_doubles_are_refused_by_name() {
    let host = Host::default();
    assert_eq!(host.set("x_start[1]", -1e200), fmi2OK);
    assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
    host.refused(
        host.exit(),
        "the energy, the work or the impulse on the support is beyond the range of doubles at t = 0 s",
    );
    assert_eq!((host.set("x_start[1]", -0.1), host.set("gravity", 0.0), host.exit()), (fmi2OK, fmi2OK, fmi2OK));
    // Ball 5 is pushed away: where it is can still be told, its energy cannot, and what would be a difference of two is
    // none.
    assert_eq!(host.set_derivative("F_ext[5]", 3, 1e285), fmi2OK);
    assert_eq!(host.step(0.0, 1e4), fmi2OK);
    assert!(host.get("x[5]") > 1e300);
    for energy in ["E_total", "E_residual"] {
        assert_eq!(host.read(host.variable(energy)), None);
        let (error, expected) = (host.error(), format!("fmi2GetReal: {energy} has no value at t = 10000 s: "));
        assert!(error.starts_with(&expected), "{error}");
    }
    assert!(host.get("x[1]") == -0.1);
    host.assert_usable();
    // A push that is none ends the step.
    let host = Host::started_with("ball.mass=1e-10");
    assert_eq!(host.set("F_ext[2]", 1e300), fmi2OK);
    host.refused(host.step(0.0, 0.1), "the state of ball 2 is not finite at t = 0 s");
}

/// Legal values of extreme size end no host, and what they lead to is said where it comes up.
#[test]
fn bad_combinations_of_legal_values_are_refused_by_name() {
    let rigid = "contact.model=rigid contact.deadBand=0 pendulum.length=0.4";
    let steel = "contact.model=hertz contact.deadBand=0 pendulum.length=0.4";
    let of_coefficients = [
        ("ball.mass=1e-300 ball.massRatio[2]=1e-300", "ball.mass * ball.massRatio[2] is too small for a double"),
        ("ball.radius=1e300 ball.radiusRatio[5]=1e9", "ball.radius * ball.radiusRatio[5] is too large for a double"),
        ("ball.youngModulusRatio[1]=1e300", "ball.youngModulus * ball.youngModulusRatio[1] is too large for a double"),
        ("gravity=1e300 pendulum.length=1e-300", "gravity / (pendulum.length * pendulum.lengthRatio[1]) is too large"),
        ("pendulum.drag=1e300 ball.mass=1e-300", "pendulum.drag / (2 * ball.mass * ball.massRatio[1]) is too large"),
        ("contact.stiffness=1e300 contact.stiffnessRatio[4]=1e300", "contact.stiffnessRatio[4] is too large"),
        ("contact.deadBand=1e308 contact.gap[3]=1e308", "contact.gap[3] + contact.deadBand is too large"),
    ];
    for (settings, words) in of_coefficients {
        let host = Host::default();
        host.give(settings);
        assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
        host.refused(host.exit(), words);
        host.give("solver.method=bdf");
        host.refused(host.exit(), words);
        host.assert_usable();
    }
    // What a contact does is out of range from the start on, so that not even values of the initial state can be read.
    let desk = "pendulum.model=circular pendulum.length=0.14 pendulum.drag=0.0035 ball.mass=0.04377 ball.radius=0.011 \
                contact.model=hertz contact.deadBand=0 contact.dampingLaw=huntCrossley contact.huntCrossley=0.3 \
                x_start=-0.03,0,0,0,0";
    for (settings, contact) in [
        ("ball.massRatio[1]=1e-300 x_start[1]=0.01", 2),
        ("ball.massRatio[3]=1e-100", 2),
        ("ball.massRatio[2]=1e-300 gravity=1e100", 1),
    ] {
        let words = format!("the impulse of contact {contact} is not finite at t = 0 s");
        let host = Host::default();
        host.give(&format!("{desk} {settings}"));
        assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
        for name in ["x[1]", "a[3]", "t_next"] {
            assert_eq!(host.read(host.variable(name)), None, "{settings}: {name}");
            let error = host.error();
            assert!(error.contains(&words), "{settings}: {error}");
        }
        host.refused(host.exit(), &words);
        host.assert_usable();
    }
    let drag = Host::started_with("ball.mass=1e-300");
    let words = "pendulum.drag / (2 * ball.mass * ball.massRatio[1]) is too large for a double";
    drag.refused(drag.set("pendulum.drag", 1e300), words);
    assert_eq!(drag.step(0.0, 0.1), fmi2OK);
    // Here they are so slow that nothing happens.
    for slow in ["gravity=1e-300", "pendulum.length=1e300"] {
        for settings in [format!("{steel} {slow}"), format!("{rigid} {slow}")] {
            let host = Host::default();
            host.give(&settings);
            assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
            assert_eq!(host.sensitivity("x[1]", "x_start[1]"), 1.0, "{settings}");
            assert_eq!((host.exit(), host.step(0.0, 1.0)), (fmi2OK, fmi2OK), "{settings}");
            assert_eq!(host.get("x[1]"), -0.1);
        }
    }
}

/// A restitution of 0 is in its range, but no law of compliant contacts has it.
#[test]
fn bad_tunable_parameter_is_refused_and_the_run_goes_on() {
    let host = Host::started_with("contact.dampingLaw=constantRestitution contact.restitution=0.5");
    assert_eq!(host.step(0.0, 0.1), fmi2OK);
    host.refused(host.set("contact.restitution", 0.0), "contact.restitution ^ contact.lossRatio[1] is too small");
    assert_eq!(host.get("contact.restitution"), 0.5);
    host.refused(host.set("contact.lossRatio[2]", 1e4), "contact.restitution ^ contact.lossRatio[2] is too small");
    assert_eq!((host.step(0.1, 0.1), host.set("contact.restitution", 0.9)), (fmi2OK, fmi2OK));
    assert_eq!(host.step(0.2, 0.1), fmi2OK);
}

#[test]
fn bad_call_sets_nothing() {
    let host = Host::default();
    let references = [host.vr("ball.mass"), host.vr("gravity"), host.vr("pendulum.length")];
    host.refused(unsafe { fmi2SetReal(host.c, references.as_ptr(), 3, [2.0, 1.0, 0.0].as_ptr()) }, "pendulum.length");
    host.start();
    assert_eq!((host.get("ball.mass"), host.get("gravity")), (1.0, 9.81));

    let references = [host.vr("F_ext[1]"), host.vr("ball.mass")];
    host.refused(
        unsafe { fmi2SetReal(host.c, references.as_ptr(), 2, [5.0, 2.0].as_ptr()) },
        "ball.mass cannot be set after initialization",
    );
    assert_eq!(host.get("F_ext[1]"), 0.0);
}

#[test]
fn bad_references_and_types_are_refused() {
    let host = Host::started();
    let (mass, x, law, pulses) =
        (host.vr("ball.mass"), host.vr("x[1]"), host.vr("contact.model"), host.vr("pulses[1]"));
    let (mut real, mut integer, mut boolean, mut string) = (0.0, 0, 0, null());
    unsafe {
        for unknown in [u32::MAX, x + 5, mass + 1] {
            host.refused(fmi2GetReal(host.c, &unknown, 1, &mut real), &format!("value reference {unknown}"));
            host.refused(fmi2SetReal(host.c, &unknown, 1, &1.0), &format!("value reference {unknown}"));
            host.refused(fmi2GetString(host.c, &unknown, 1, &mut string), &format!("value reference {unknown}"));
        }
        host.refused(fmi2GetReal(host.c, &law, 1, &mut real), "contact.model is of type Enumeration, not Real");
        host.refused(fmi2GetReal(host.c, &pulses, 1, &mut real), "pulses[1] is of type Integer, not Real");
        host.refused(fmi2GetInteger(host.c, &x, 1, &mut integer), "x[1] is of type Real, not Integer");
        host.refused(fmi2GetBoolean(host.c, &x, 1, &mut boolean), "x[1] is of type Real, not Boolean");
        host.refused(fmi2GetString(host.c, &x, 1, &mut string), "x[1] is of type Real, not String");
        host.refused(fmi2SetInteger(host.c, &mass, 1, &1), "ball.mass is of type Real, not Integer");
        host.refused(fmi2SetReal(host.c, &law, 1, &1.0), "contact.model is of type Enumeration, not Real");
        host.refused(fmi2SetBoolean(host.c, &host.vr("inContact[1]"), 1, &1), "inContact[1] cannot be set");
        host.refused(fmi2SetString(host.c, &mass, 1, &c"heavy".as_ptr()), "ball.mass is of type Real, not String");
    }
    for name in ["x[1]", "E_residual", "pendulum.period"] {
        host.refused(host.set(name, 1.0), &format!("{name} cannot be set"));
    }
    assert_eq!(host.step(0.0, 0.01), fmi2OK);
}

#[test]
fn bad_communication_steps_are_refused() {
    let host = Host::default();
    host.refused(host.step(0.0, 0.01), "fmi2DoStep: not allowed in the instantiated state; allowed: in step mode");
    host.start();
    // What is to act in the next step stays.
    assert_eq!(host.set_derivative("F_ext[1]", 1, 0.1), fmi2OK);
    let before = host.to_bytes();
    for step in [0.0, -0.0, -0.01, f64::NAN, f64::INFINITY] {
        host.refused(host.step(0.0, step), "allowed: finite and > 0 s");
    }
    for time in [1e-11, -1e-11, f64::NAN, f64::INFINITY, 1.0] {
        host.refused(host.step(time, 0.01), "currentCommunicationPoint = ");
    }
    assert!(host.to_bytes() == before);
    assert_eq!(host.step(0.0, 0.01), fmi2OK);
    assert_eq!(host.step(0.01 + 5e-13, 0.01), fmi2OK);
    assert_eq!(host.step(0.02 + 5e-13, 1e-9), fmi2OK);
}

#[test]
fn bad_experiments_are_refused() {
    let host = Host::default();
    host.refused(host.enter(), "experiment must be set up first");
    host.refused(host.set_up(f64::NAN), "startTime = NaN s");
    for stop in [f64::NAN, 0.0, -1.0] {
        host.refused(unsafe { fmi2SetupExperiment(host.c, 0, 0.0, 0.0, 1, stop) }, "stopTime = ");
    }
    // Invalid tolerances are ignored.
    for tolerance in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
        assert_eq!(unsafe { fmi2SetupExperiment(host.c, 1, tolerance, 0.0, 1, 10.0) }, fmi2OK);
    }
    assert!(host.log().is_empty());
    host.assert_usable();
}

#[test]
fn bad_null_pointers_are_refused_unless_nothing_is_asked_for() {
    let host = Host::started();
    let x = host.vr("x[1]");
    unsafe {
        assert_eq!(fmi2GetReal(host.c, null(), 0, null_mut()), fmi2OK);
        assert_eq!(fmi2SetReal(host.c, null(), 0, null()), fmi2OK);
        assert_eq!(fmi2GetString(host.c, null(), 0, null_mut()), fmi2OK);
        assert_eq!(fmi2SetBoolean(host.c, null(), 0, null()), fmi2OK);
        assert!(host.log().is_empty());
        let mut value = 0.0;
        host.refused(fmi2GetReal(host.c, null(), 1, &mut value), "vr = NULL is refused; allowed: an array of 1");
        host.refused(fmi2GetReal(host.c, &x, 1, null_mut()), "value = NULL");
        host.refused(fmi2SetBoolean(host.c, &x, 1, null()), "value = NULL");
        host.refused(fmi2SetString(host.c, &x, 1, null()), "value = NULL");
        host.refused(fmi2GetReal(host.c, &x, 1, 9 as *mut f64), "value = 0x9 is refused");
        host.refused(fmi2SetReal(host.c, &x, usize::MAX, &value), "an array of");
        host.refused(fmi2SetDebugLogging(host.c, 1, 1, null()), "categories = NULL");
        host.refused(fmi2SetDebugLogging(host.c, 1, 1, &null()), "category = NULL");
        host.refused(fmi2GetRealStatus(host.c, fmi2LastSuccessfulTime, null_mut()), "value = NULL");
    }
    host.assert_usable();
}

/// One guard stands before every function.
#[test]
fn bad_component_pointers_are_refused_by_every_function() {
    let (mut real, mut state) = (0.0, null_mut());
    let zeros = [0_u64; 64]; // Memory that is no component.
    for c in [null_mut(), zeros.as_ptr().cast_mut().cast(), 1_usize as fmi2Component] {
        let answers = unsafe {
            [
                fmi2SetDebugLogging(c, 1, 0, null()),
                fmi2EnterInitializationMode(c),
                fmi2GetReal(c, &0, 1, &mut real),
                fmi2GetFMUstate(c, &mut state),
                fmi2DoStep(c, 0.0, 0.01, 1),
            ]
        };
        assert_eq!(answers, [fmi2Error; 5]);
        unsafe { fmi2FreeInstance(c) };
    }
}

fn refused(instantiate: Instantiate, expected: &str) {
    let lines = instantiate.host().map(|_| ()).unwrap_err();
    let [line] = lines.as_slice() else { panic!("{lines:?}") };
    assert_eq!((line.status, line.category.as_str()), (fmi2Error, "logStatusError"));
    assert!(line.text.starts_with("fmi2Instantiate: ") && line.text.contains(expected), "{}", line.text);
}

#[test]
fn bad_guids_and_kinds_are_refused_at_instantiation() {
    let wrong = "{00000000-0000-0000-0000-000000000000}".to_owned();
    refused(Instantiate { guid: Some(wrong), ..Default::default() }, &format!("allowed: {}", guid(5)));
    refused(Instantiate { guid: None, ..Default::default() }, "fmuGUID =  is refused");
    refused(Instantiate { guid: Some(guid(4)), ..Default::default() }, "fmuGUID");
    refused(Instantiate { kind: -1, ..Default::default() }, "fmuType = -1 is refused");
    refused(Instantiate { kind: 7, ..Default::default() }, "fmuType = 7 is refused");
    refused(Instantiate { name: None, ..Default::default() }, "instanceName");
    refused(Instantiate { name: Some(""), ..Default::default() }, "instanceName");
    assert!(unsafe { fmi2Instantiate(c"a".as_ptr(), 1, c"b".as_ptr(), null(), null(), 0, 0) }.is_null());
}

#[test]
fn resources_decide_what_is_instantiated() {
    let mut recipe = Recipe::new(3);
    recipe.start.insert("x_start[1]".into(), StartValue::Number(-0.25));
    let (folder, location) = resources("decide", recipe.to_json().as_bytes());
    let own = newtons_cradle::variables::Description::of(&recipe.settings().unwrap()).guid();
    for location in [format!("{location}/"), location.replace("file:///", "file:/"), folder.display().to_string()] {
        let host = Instantiate { guid: Some(own.clone()), location: Some(location), balls: 3, ..Default::default() };
        let host = host.host().unwrap();
        host.start();
        assert_eq!((host.get("x[1]"), host.get("x[3]")), (-0.25, 0.0));
        let mut value = 0.0;
        let fourth = Host::default().vr("x[4]");
        assert_eq!(unsafe { fmi2GetReal(host.c, &fourth, 1, &mut value) }, fmi2Error);
        assert_eq!(host.reset(), fmi2OK);
        host.start();
        assert_eq!(host.get("x_start[1]"), -0.25);
    }
    refused(Instantiate { location: Some(location), ..Default::default() }, &format!("allowed: {own}"));
}

#[test]
fn resources_missing_mean_the_defaults_and_damaged_ones_are_refused() {
    let (folder, location) = resources("damaged", b"{ \"format\": 1, ");
    let with = |location: &str| Instantiate { location: Some(location.to_owned()), ..Default::default() };
    refused(with(&location), FILE_NAME);
    fs::write(folder.join(FILE_NAME), b"{\"format\":1,\"balls\":0}").unwrap();
    refused(with(&location), "balls = 0 is refused; allowed: 1 to 10000");
    fs::write(folder.join(FILE_NAME), b"{\"format\":1,\"balls\":5,\"start\":{\"ball.mass\":-1}}").unwrap();
    refused(with(&location), "ball.mass = -1 kg is refused");
    fs::remove_file(folder.join(FILE_NAME)).unwrap();
    with(&location).host().unwrap().assert_usable();
    with("").host().unwrap().assert_usable();
    with("file:///no/such/folder").host().unwrap().assert_usable();
    fs::create_dir_all(folder.join(FILE_NAME)).unwrap();
    refused(with(&location), FILE_NAME);
    fs::remove_dir(folder.join(FILE_NAME)).unwrap();
    refused(with("https://example.org/resources"), "fmuResourceLocation = https://example.org/resources is refused");
}

/// What is no file may have no end, and a pipe waits for somebody to write into it.
#[cfg(unix)]
#[test]
fn resources_that_are_no_regular_file_or_too_large_are_refused() {
    let (folder, location) = resources("devices", b"");
    let with = || Instantiate { location: Some(location.clone()), ..Default::default() };
    let file = folder.join(FILE_NAME);
    fs::File::create(&file).unwrap().set_len((32 << 20) + 1).unwrap();
    refused(with(), &format!("{FILE_NAME}: it is too large; allowed: at most 33554432 bytes"));
    fs::remove_file(&file).unwrap();
    std::os::unix::fs::symlink("/dev/null", &file).unwrap();
    refused(with(), "it is a device, a pipe or a socket; allowed: a regular file");
    fs::remove_file(&file).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(&file).status().unwrap().success());
    // Were it opened, this would be what is read.
    let pipe = file.clone();
    let writer = std::thread::spawn(move || fs::write(pipe, "{"));
    refused(with(), "it is a device, a pipe or a socket; allowed: a regular file");
    assert_eq!(fs::read(&file).unwrap(), b"{");
    writer.join().unwrap().unwrap();
    fs::remove_file(&file).unwrap();
}
