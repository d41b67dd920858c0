orchestrate fmus --copy .                                                  # plant.fmu, controller.fmu, allocator.fmu and the other blocks
orchestrate export scenarios/paper_no_singularity.yaml --ssp adcs.ssp      # the whole loop as an SSP archive
orchestrate export scenarios/paper_no_singularity.yaml --container adcs.fmu   # the whole loop as one FMU
orchestrate adcs.ssp                                                       # runs an SSP archive, this or another
