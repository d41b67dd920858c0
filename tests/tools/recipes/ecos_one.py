from ecospy import EcosSimulation, EcosSimulationStructure

structure = EcosSimulationStructure()
structure.add_model("plant", "plant.fmu")
structure.add_parameter_set(
    "start", {"plant::omega_B0[1]": 0.04, "plant::omega_B0[2]": -0.0789, "plant::omega_B0[3]": 0.04}
)
time, rate = [], []
with EcosSimulation(structure=structure, step_size=0.1) as simulation:
    simulation.init(parameter_set="start")
    for k in range(600):
        simulation.step()
        time.append((k + 1) * 0.1)
        rate.append(simulation.get_real("plant::omega_B[2]"))
