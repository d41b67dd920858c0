"""One orbit of the same satellite by Basilisk, for tests.bench.

`DURATION` (s): flies it once, and prints seconds of imports, of set-up and of the run. `DURATION RUNS PROCESSES`: flies
it by Basilisk's Monte Carlo controller, and prints the seconds that all runs took and how many failed.

Field (WMM), drag on ten facets in an exponential atmosphere, gravity gradient, one wheel at a constant motor torque,
three rods at constant dipoles; RK4 at 0.1 s, states recorded at 1 s. No control law flies, so Basilisk does less here
than the FMUs. The Monte Carlo retains no data, since Basilisk 2.12 waits a second in each run that does.
"""

from __future__ import annotations

import sys
import tempfile
import time
from typing import Any

import numpy as np

BEGUN = time.perf_counter()

from Basilisk.architecture import messaging  # noqa: E402
from Basilisk.simulation import (  # noqa: E402
    GravityGradientEffector,
    MtbEffector,
    exponentialAtmosphere,
    facetDragDynamicEffector,
    magneticFieldWMM,
    reactionWheelStateEffector,
    spacecraft,
)
from Basilisk.utilities import (  # noqa: E402
    SimulationBaseClass,
    macros,
    simIncludeGravBody,
    simIncludeRW,
)
from Basilisk.utilities.MonteCarlo import Controller, Dispersions  # noqa: E402

IMPORTED = time.perf_counter()


def build(step: float = 0.1) -> Any:
    """The simulation, not yet initialized; its first model is the spacecraft, its `log` the states at 1 s."""
    from plant.drag import octagonal_cylinder
    from plant.tables.field_models import _package_file
    from tests.blocks import parameters

    p = parameters("plant")
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("dynamics").addTask(simulation.CreateNewTask("step", macros.sec2nano(step)))
    body = spacecraft.Spacecraft()
    r, v = p.orbit.position_velocity(0.0)
    body.hub.mHub = 50.0
    body.hub.IHubPntBc_B = p.J_B.tolist()
    body.hub.r_CN_NInit, body.hub.v_CN_NInit = r.tolist(), v.tolist()
    body.hub.omega_BN_BInit = [0.04, -0.0789, 0.04]
    simulation.AddModelToTask("step", body)
    gravity = simIncludeGravBody.gravBodyFactory()
    earth = gravity.createEarth()
    earth.isCentralBody = True
    gravity.addBodiesTo(body)

    gradient = GravityGradientEffector.GravityGradientEffector()
    gradient.addPlanetName(earth.planetName)
    body.addDynamicEffector(gradient)
    simulation.AddModelToTask("step", gradient)

    field = magneticFieldWMM.MagneticFieldWMM()
    field.configureWMMFile(str(_package_file("pygeomag", "wmm/WMM_2010.COF")))
    field.epochDateFractionalYear = 2010.5
    field.addSpacecraftToModel(body.scStateOutMsg)
    simulation.AddModelToTask("step", field)

    air = exponentialAtmosphere.ExponentialAtmosphere()
    air.planetRadius, air.baseDensity, air.scaleHeight = 6378137.0, 1e-12, 70e3
    air.addSpacecraftToModel(body.scStateOutMsg)
    simulation.AddModelToTask("step", air)
    drag = facetDragDynamicEffector.FacetDragDynamicEffector()
    plates = octagonal_cylinder(0.65, 0.8, "x")
    for normal, area, centre in zip(plates.normals, plates.areas, plates.centres, strict=True):
        drag.addFacet(float(area), 2.2, normal.tolist(), centre.tolist())
    drag.atmoDensInMsg.subscribeTo(air.envOutMsgs[0])
    body.addDynamicEffector(drag)
    simulation.AddModelToTask("step", drag)

    wheels = simIncludeRW.rwFactory()
    wheels.create(
        "custom", [1.0, 0.0, 0.0], Omega=0.0, Js=1.47e-5, u_max=3e-3, Omega_max=2041.0 * macros.rpm2radsec * 30 / np.pi
    )
    wheel = reactionWheelStateEffector.ReactionWheelStateEffector()
    wheels.addToSpacecraft("wheel", wheel, body)
    torque = messaging.ArrayMotorTorqueMsg().write(messaging.ArrayMotorTorqueMsgPayload(motorTorque=[1e-6]))
    wheel.rwMotorCmdInMsg.subscribeTo(torque)
    simulation.AddModelToTask("step", wheel)

    rods = MtbEffector.MtbEffector()
    shape = messaging.MTBArrayConfigMsgPayload()
    shape.numMTB = 3
    shape.GtMatrix_B = p.rods_to_body.ravel().tolist()
    shape.maxMtbDipoles = [25.0] * 3
    rods.mtbParamsInMsg.subscribeTo(shape_message := messaging.MTBArrayConfigMsg().write(shape))
    command = messaging.MTBCmdMsg().write(messaging.MTBCmdMsgPayload(mtbDipoleCmds=[1.0, -1.0, 0.5]))
    rods.mtbCmdInMsg.subscribeTo(command)
    rods.magInMsg.subscribeTo(field.envOutMsgs[0])
    body.addDynamicEffector(rods)
    simulation.AddModelToTask("step", rods)

    log = body.scStateOutMsg.recorder(macros.sec2nano(1.0))
    simulation.AddModelToTask("step", log)
    simulation.log = log
    simulation.kept = (gravity, wheels, torque, shape_message, command)  # C++ points to them
    return simulation


def once(duration: float) -> None:
    """One orbit."""
    simulation = build()
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(duration))
    ready = time.perf_counter()
    simulation.ExecuteSimulation()
    done = time.perf_counter()
    assert simulation.log.times()[-1] == macros.sec2nano(duration)
    print(IMPORTED - BEGUN, ready - IMPORTED, done - ready)


class Execute:
    """What the controller does with each simulation; it is sent to the processes."""

    def __init__(self, duration: float) -> None:
        self.duration = duration

    def __call__(self, simulation: Any) -> None:
        simulation.InitializeSimulation()
        simulation.ConfigureStopTime(macros.sec2nano(self.duration))
        simulation.ExecuteSimulation()


def many(duration: float, runs: int, processes: int) -> None:
    """Orbits from other attitudes and rates."""
    controller = Controller.Controller()
    controller.setSimulationFunction(build)
    controller.setExecutionFunction(Execute(duration))
    controller.setExecutionCount(runs)
    controller.setThreadCount(processes)
    hub = "TaskList[0].TaskModels[0].hub"
    controller.addDispersion(Dispersions.UniformEulerAngleMRPDispersion(f"{hub}.sigma_BNInit"))
    controller.addDispersion(Dispersions.NormalVectorCartDispersion(f"{hub}.omega_BN_BInit", 0.0, 0.056))  # rad/s
    with tempfile.TemporaryDirectory() as folder:
        controller.setArchiveDir(f"{folder}/runs")
        begun = time.perf_counter()
        failed = controller.executeSimulations()
        print(time.perf_counter() - begun, len(failed))


if __name__ == "__main__":
    if len(sys.argv) > 2:
        many(float(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
    else:
        once(float(sys.argv[1]))
