//! Losses by a coefficient of restitution.

use super::support::{BINARY, Folder, text};

#[test]
fn build_sets_losses_by_a_restitution() {
    let folder = Folder::new("restitution");
    let built = |words: &str| format!("build {BINARY} --out x.fmu {words}");
    let default = "Set contact.dampingLaw = constantRestitution, contact.restitution = 0.9: two balls, free and alone, \
                   that meet at any speed part at 0.9 of it";
    for (words, told, in_file) in [
        ("--restitution 0.9", default, "\"contact.restitution\": 0.9"),
        ("--restitution 0.9@2", default, "\"contact.dampingLaw\": \"constantRestitution\""),
        ("--preset steel --restitution 0.9", default, "\"contact.restitution\": 0.9"),
        ("--preset rigid --restitution 0", "Set contact.restitution = 0: two balls", "\"contact.restitution\": 0.0"),
        ("--preset desk --restitution 0.9@0.25", "Set contact.huntCrossley = 0.6659278027", "0.6659278027"),
        (
            "--preset tapered --restitution 0.9@1",
            " s/m: two balls, free and alone, that meet at 1 m/s",
            "0.16648195068",
        ),
        (
            "--preset tapered --set contact.dampingLaw=viscoelastic --restitution 0.9@1",
            "of unlike pairs, balls 1 and 2, free and alone, that meet at 1 m/s part at 0.9 of it",
            "\"contact.relaxationTime\": 1.52054427246",
        ),
        ("--set contact.lossRatio[1]=2 --restitution 0.81", "of unlike pairs", "\"contact.restitution\": 0.9"),
    ] {
        folder.run(&built(words)).with(0, &[told]);
        let recipe = text(&folder.entries("x.fmu"), "resources/cradle.json");
        assert!(recipe.contains(in_file), "{words}: {recipe}");
    }
    let at_speed = "--restitution 0.9: by this damping law the coefficient of restitution depends on the speed";
    for (words, complaint) in [
        ("--preset desk --restitution 0.9", at_speed),
        ("--set contact.dampingLaw=kelvinVoigt --restitution 0.9", at_speed),
        (
            "--restitution 0",
            "--restitution 0: the coefficient of restitution = 0 is refused; allowed: above 0, at most 1",
        ),
        ("--restitution 1.5", "the coefficient of restitution = 1.5 is refused"),
        ("--restitution 0.9@-1", "--restitution 0.9@-1: the speed = -1 m/s is refused; allowed: above 0"),
        ("--restitution 0,9", "allowed: as 0.9 or 0.9@1.0, a speed in m/s"),
        ("--balls 1 --restitution 0.9", "the number of balls = 1 is refused; allowed: at least 2"),
        ("--set contact.lossRatio=0,1,1,1 --restitution 0.9", "contact.lossRatio[1] = 0 is refused"),
    ] {
        folder.run(&built(words)).with(2, &[complaint]);
    }
}
