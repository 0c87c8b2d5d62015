//! What distinguishes an effect from others where no drive does.

/// What to record.
pub fn to_record(id: &str) -> String {
    let what = match id {
        "grade" => "pitch_rad, or the same drive in the opposite direction",
        "winding-temperature" => "motor1_temp_c … of every motor",
        "compute-load" => "cpu_percent, with the processor idle and busy",
        "supply-sag" => "bus_v at the drives",
        "payload-mislabel" => "the robot's weight on scales before each run",
        "sensor-gain" | "sensor-offset" => "a second power meter, at rest and in motion",
        "sensor-delay" => "one clock for power and speed",
        "speed-scale" => "the distance by tape measure",
        "static-step" => "which consumers are switched on, and when",
        "lubricant-warm-up" => "a run from cold and one right behind it",
        "surface-switch" | "rolling-resistance-change" => "runs with other payloads on the same floor",
        _ => "runs with other payloads and speeds",
    };
    format!("{id}: {what}")
}
