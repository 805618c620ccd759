"""A run as a 3D animation: one HTML file with data, player and three.js, which needs no network.

save_page("cradle.html", from_fmu("target/fmu/NewtonsCradle.fmu", stop=10.0))
save_page("result.html", from_csv("result.csv"))
"""

from .page import PageError, save_page
from .recording import Recording, RecordingError, from_csv, from_fmu

__all__ = ["PageError", "Recording", "RecordingError", "from_csv", "from_fmu", "save_page"]
