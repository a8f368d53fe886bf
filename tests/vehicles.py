"""Vehicles of all sizes, and studies that `jaxbuffer init` makes of them."""

from jaxbuffer.cli.entry import run

KINDS = ("probe_cone", "docking3d")
# From a cubesat's servicer to a module that docks at a station: masses, speeds, miss, attitude.
VEHICLES = {
    "4 kg": ("4 kg", "4 kg", "0.03:0.08", "5 mm", "1 deg"),
    "20 kg": ("20 kg", "20 kg", "0.08:0.15", "1 cm", "0 deg"),
    "24 kg": ("24 kg", "24 kg", "0.05:0.15", "1 cm", "2 deg"),
    "1.2 t": ("1200 kg", "3.5 t", "0.05:0.15", "40 mm", "2 deg"),
    "8 t": ("8 t", "8 t", "0.06:0.12", "5 cm", "2 deg"),
    "420 t": ("10 t", "420 t", "0.03:0.10", "10 cm", "3 deg"),
}


def written(folder, active, passive, speeds, miss, attitude, kind="probe_cone"):
    """The file of a study of such vehicles."""
    file = folder / "study.toml"
    numbers = ["--kind", kind, "--active-mass", active, "--passive-mass", passive, "--speeds", speeds]
    assert run(["init", str(file), *numbers, "--miss", miss, "--attitude", attitude]) == 0
    return file
