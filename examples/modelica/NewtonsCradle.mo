within ;
package NewtonsCradle "Newton's cradle in models of translational mechanics, around its FMU"

  partial block Signals "Inputs and outputs of the FMU that the cradle needs"
    parameter Integer n(min=1) = 5 "Number of balls";
    Modelica.Blocks.Interfaces.RealInput F_ext[n](each unit="N") "External force on each ball";
    Modelica.Blocks.Interfaces.RealInput a_support(unit="m/s2") "Acceleration of the support";
    Modelica.Blocks.Interfaces.RealOutput x[n](each unit="m") "Position of each ball, relative to the support";
    Modelica.Blocks.Interfaces.RealOutput v[n](each unit="m/s") "Velocity of each ball";
    Modelica.Blocks.Interfaces.RealOutput F_support(unit="N") "Horizontal force on the support";
  end Signals;

  block Pendulums "The cradle without contacts, where no FMU is at hand"
    extends Signals;
    parameter Real m(unit="kg") = 1 "Mass of a ball";
    parameter Real k(unit="N/m") = 5 "Its weight over the length of its pendulum";
    parameter Real x_start[n](each unit="m") = cat(1, {-0.1}, zeros(n - 1)) "Positions at the start";
  initial equation
    x = x_start;
    v = zeros(n);
  equation
    der(x) = v;
    m*der(v) = F_ext - k*x - m*a_support*ones(n);
    F_support = k*sum(x);
  end Pendulums;

  model Cradle "The cradle with a flange at its support and one at each ball"
    parameter Integer n(min=1) = 5 "Number of balls";
    replaceable Pendulums fmu(n=n) constrainedby Signals(n=n) "To be redeclared by the class of the FMU";
    Modelica.Mechanics.Translational.Interfaces.Flange_a support "Where the pendulums hang";
    Modelica.Mechanics.Translational.Interfaces.Flange_b ball[n] "The balls: position in space, external force";
  protected
    Real v_support(unit="m/s") "Velocity of the support";
  equation
    v_support = der(support.s);
    fmu.a_support = der(v_support);
    support.f = -fmu.F_support;
    for i in 1:n loop
      ball[i].s = support.s + fmu.x[i];
      fmu.F_ext[i] = ball[i].f;
    end for;
  end Cradle;

  model Example "The last ball at a spring and a damper, the support at rest"
    Cradle cradle(n=2);
    Modelica.Mechanics.Translational.Components.Fixed fixed;
    Modelica.Mechanics.Translational.Components.Fixed wall;
    Modelica.Mechanics.Translational.Components.SpringDamper spring(c=10, d=0.5);
  equation
    connect(fixed.flange, cradle.support);
    connect(cradle.ball[2], spring.flange_a);
    connect(spring.flange_b, wall.flange);
  end Example;

  annotation(
    version="0.1.0",
    uses(Modelica(version="4.0.0")),
    Documentation(info="<html><p>Import the FMU in your tool, extend Signals by a block that contains the imported class and connects
      its variables, and redeclare <code>fmu</code> of Cradle by it. Connect flanges to springs or gaps: a flange of the
      cradle has the position that the FMU gives it. A damper needs its derivative, which not every tool can take of an
      FMU's output.</p></html>"));
end NewtonsCradle;
