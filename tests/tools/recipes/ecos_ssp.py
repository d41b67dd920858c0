from ecospy import EcosSimulation

step = 0.1
time, error = [], []
with EcosSimulation(ssp_path="adcs.ssp", step_size=step) as simulation:
    simulation.init(parameter_set="start")
    for k in range(round(120 / step)):
        simulation.step()
        time.append((k + 1) * step)
        error.append(simulation.get_real("controller::attitude_error"))
