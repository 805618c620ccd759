"""Modelica: the package around the FMU, and the paper's model by hand, in the compiler rumoca."""

import math

import newtons_cradle as nc
import numpy as np
import pytest
from conftest import ROOT

pytestmark = pytest.mark.all

rumoca = pytest.importorskip("rumoca")

#: For the classes of the Modelica library that the package and its example need: the library is in no registry.
LIBRARY = """
package Modelica
  package Blocks
    package Interfaces
      connector RealInput = input Real;
      connector RealOutput = output Real;
    end Interfaces;
  end Blocks;
  package Mechanics
    package Translational
      package Interfaces
        connector Flange_a
          Real s;
          flow Real f;
        end Flange_a;
        connector Flange_b
          Real s;
          flow Real f;
        end Flange_b;
      end Interfaces;
      package Components
        model Fixed
          Modelica.Mechanics.Translational.Interfaces.Flange_b flange;
        equation
          flange.s = 0;
        end Fixed;
        model SpringDamper
          parameter Real c;
          parameter Real d;
          Modelica.Mechanics.Translational.Interfaces.Flange_a flange_a;
          Modelica.Mechanics.Translational.Interfaces.Flange_b flange_b;
          Real s_rel(start=0);
        equation
          s_rel = flange_b.s - flange_a.s;
          flange_b.f = c*s_rel + d*der(s_rel);
          flange_a.f = -flange_b.f;
        end SpringDamper;
      end Components;
    end Translational;
  end Mechanics;
end Modelica;
"""


def simulated(source: str, model: str, stop: float, **options) -> tuple[np.ndarray, dict]:
    """The times (s) of a run, and its columns by name."""
    result = rumoca.Session().loads(source, model=model).simulate((0.0, stop), dt=0.01, **options)
    return np.asarray(result.time), result.to_dict()["data"]


def test_modelica_package_around_the_fmu():
    """Its example, with the pendulums that stand in for the FMU, both lifted: the motion has a closed form."""
    package = (ROOT / "examples/modelica/NewtonsCradle.mo").read_text(encoding="utf-8").replace("within ;", "")
    example = "Cradle cradle(n=2);"
    assert example in package
    package = package.replace(example, "Cradle cradle(n=2, fmu(x_start={-0.1, 0.05}));")
    config = rumoca.SimConfig(rtol=1e-9, atol=1e-12)
    time, columns = simulated(LIBRARY + package, "NewtonsCradle.Example", 3.0, config=config)
    assert len(time) >= 301 and time[-1] == 3.0
    # Of 1 kg, with 5 N/m for gravity, 10 N/m of the spring and 0.5 N s/m of the damper.
    free, rate = -0.1 * np.cos(math.sqrt(5.0) * time), math.sqrt(15.0 - 0.25**2)
    damped = 0.05 * np.exp(-0.25 * time) * (np.cos(rate * time) + 0.25 / rate * np.sin(rate * time))
    for name, expected in (("x[1]", free), ("x[2]", damped)):
        for place in (f"cradle.fmu.{name}", f"cradle.ball{name[1:]}.s"):
            assert np.allclose(columns[place], expected, atol=1e-7), place
    support = -(5.0 * (free + damped))
    assert np.allclose(columns["cradle.support.f"], support, atol=1e-6)


def test_modelica_model_of_the_paper(fmu):
    """Until after its first click, in which two balls hand their motion on to two others."""
    source = (ROOT / "examples/modelica/Paper.mo").read_text(encoding="utf-8")
    config = rumoca.SimConfig(solver="rk-like", rtol=1e-6, atol=1e-9)
    time, columns = simulated(source, "Paper", 2.0, config=config)
    right = fmu.simulate(nc.figure5(), stop=2.0, record=["x"])["x"]
    rows = np.searchsorted(time, np.arange(201) / 100 + 1e-9) - 1
    found = np.column_stack([columns[f"x[{i}]"][rows] for i in range(1, 6)])
    assert np.allclose(found, right, atol=1e-5) and np.abs(right[-1, 3:] - 0.238).max() < 1e-3
