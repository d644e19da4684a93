//! The integration tests: one binary, a module per subject.

mod air;
mod air_commands;
mod architecture;
mod byte_identity;
mod charts;
mod cli;
mod cli_commands;
mod cli_recordings;
mod commands;
mod consistency;
mod contacts;
mod damage;
mod encoding;
mod energy;
mod equilibrium;
mod explain;
mod friction;
mod friction_proofs;
mod golden;
mod inbound;
mod inbound_objects;
mod inbound_property;
mod inbound_services;
mod keyframe;
mod lab;
mod lab_cli;
mod lab_defects;
mod lab_drape;
mod lab_measure;
mod lab_modes;
mod lab_scenes;
mod lab_verify;
mod layer_events;
mod layers;
mod layers_fold;
mod messages;
mod methods;
mod motion;
mod needs;
mod order;
mod orders;
mod overlap;
mod pace;
mod pictures;
mod plan;
mod python;
mod recording;
mod refusal;
mod refusal_of_air;
mod replay;
mod resume;
#[cfg(feature = "ros2")]
mod ros2;
mod samples;
mod scene;
mod schema_reader;
mod session;
#[cfg(feature = "iceoryx2")]
mod shared_hostile;
#[cfg(feature = "iceoryx2")]
mod shared_measure;
#[cfg(feature = "iceoryx2")]
mod shared_memory;
#[cfg(feature = "iceoryx2")]
mod shared_processes;
mod stability;
mod stability_shapes;
mod surface_files;
mod surfaces;
mod tamper;
mod tidy;
mod tunnelling;
mod type_hashes;
mod verify;
mod views;
mod work;
