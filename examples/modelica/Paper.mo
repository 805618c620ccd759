model Paper "Breedveld's cradle as his paper has it: five balls on linear pendulums, each contact a stiff spring"
  parameter Integer n = 5 "Number of balls";
  parameter Real m(unit="kg") = 1 "Mass of a ball";
  parameter Real g(unit="m/s2") = 9.81 "Gravity";
  parameter Real L(unit="m") = 1.962 "Length of a pendulum";
  parameter Real k(unit="N/m") = 1e14 "Stiffness of a contact";
  parameter Real band(unit="m") = 2.6e-7 "Dead band of a contact";
  Real x[n](start={-1, -1, 0, 0, 0}, each fixed=true, each unit="m") "Positions";
  Real v[n](each start=0, each fixed=true, each unit="m/s") "Velocities";
  Real F[n + 1](each unit="N") "Contact forces: on the left of ball i, and behind the last ball";
equation
  F[1] = 0;
  F[n + 1] = 0;
  for i in 1:n - 1 loop
    F[i + 1] = if x[i] - x[i + 1] > band then k*(x[i] - x[i + 1] - band) else 0;
  end for;
  for i in 1:n loop
    der(x[i]) = v[i];
    m*der(v[i]) = F[i] - F[i + 1] - m*g/L*x[i];
  end for;
end Paper;
