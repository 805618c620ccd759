//! Calls of FMI 3.0 in corners: within others, refused, or after the number of balls has changed.

use newtons_cradle::fmi3::fmi3Status::fmi3Discard;

use super::*;

/// A host that meets an error within a step may clean up at once; the instance is still in the middle of that step.
#[test]
fn an_instance_is_not_freed_in_the_middle_of_a_step() {
    let answer = Host::ask(Intermediate, |c| {
        let refused = do_step(c);
        unsafe { fmi3FreeInstance(c) };
        assert_eq!(unsafe { fmi3GetUInt64(c, &vr("n"), 1, &mut 0, 1) }, fmi3OK, "it is still there");
        refused
    });
    assert_eq!(answer, fmi3Error);
}

#[test]
fn a_refused_number_of_balls_changes_nothing() {
    let host = Host::new();
    let (n, numbers) = ([vr("n"); 2], [3, 0]);
    let mut balls = 0;
    unsafe {
        assert_eq!(fmi3EnterConfigurationMode(host.c), fmi3OK);
        assert_eq!(fmi3SetUInt64(host.c, n.as_ptr(), 2, numbers.as_ptr(), 2), fmi3Discard);
        assert_eq!(fmi3ExitConfigurationMode(host.c), fmi3OK);
        assert_eq!(fmi3EnterInitializationMode(host.c, 0, 0.0, 0.0, 0, 0.0), fmi3OK);
        assert_eq!(fmi3GetUInt64(host.c, n.as_ptr(), 1, &mut balls, 1), fmi3OK);
    }
    assert_eq!(balls, 5);
}

/// Slopes act over a step: at a point nothing depends on them.
#[test]
fn nothing_depends_on_slopes_at_a_point() {
    let host = Host::new();
    let knowns = [vr("F_ext"), vr("der(F_ext)"), vr("der(a_support)")];
    let (seed, mut along) = ([1.0; 11], [f64::NAN; 5]);
    let mut back = [f64::NAN; 11];
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(host.c, 0, 0.0, 0.0, 0, 0.0), fmi3OK);
        let found = fmi3GetDirectionalDerivative(
            host.c,
            &vr("a"),
            1,
            knowns.as_ptr(),
            3,
            seed.as_ptr(),
            11,
            along.as_mut_ptr(),
            5,
        );
        assert_eq!(found, fmi3OK);
        let found =
            fmi3GetAdjointDerivative(host.c, &vr("a"), 1, knowns.as_ptr(), 3, seed.as_ptr(), 5, back.as_mut_ptr(), 11);
        assert_eq!(found, fmi3OK);
    }
    assert_eq!(along, [1.0; 5]);
    assert_eq!(back, [1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
}
