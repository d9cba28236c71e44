//! Poses of a robot and angles of its wheels over time, from a table.

/// Most samples of a record: a day at 50 Hz.
const MAX_SAMPLES: usize = 4_320_000;
/// Most wheels.
const MAX_WHEELS: usize = 64;

/// Poses and wheels, sample by sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    times: Vec<f64>,
    /// x and y, m, and yaw, rad.
    poses: Vec<[f64; 3]>,
    /// Angles of the wheels, rad.
    angles: Vec<Vec<f64>>,
}

/// A table that is no record of one robot.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum RecordError {
    /// A column is missing.
    #[error("no column `{0}`: expected time, x, y, yaw, and wheel_angle_1 .. or wheel_speed_1 ..")]
    Column(String),
    /// A cell has no number.
    #[error("line {line}, column `{column}`: {got:?} is no number")]
    Cell {
        /// Line, from 1.
        line: usize,
        /// Column.
        column: String,
        /// Text of the cell.
        got: String,
    },
    /// A time is not after the one before.
    #[error("line {line}: the time {time} s is not after {before} s")]
    Order {
        /// Line, from 1.
        line: usize,
        /// Its time, s.
        time: f64,
        /// Time of the line before, s.
        before: f64,
    },
    /// The table has several robots.
    #[error("the table has robots {one} and {other}: choose one with --robot")]
    Robots {
        /// A robot's number.
        one: String,
        /// Another's.
        other: String,
    },
    /// A line has another number of cells than the head.
    #[error("{0}")]
    Table(String),
    /// The table is too large.
    #[error("more than {MAX_SAMPLES} lines or {MAX_WHEELS} wheels")]
    Size,
}

impl Record {
    /// Reads a table as `usarsim log export --csv` writes it: time (s), x, y (m), yaw (rad), and for each driven wheel its angle (rad) or its
    /// speed (rad/s). Other columns are left aside. With `robot` only that robot's lines count.
    ///
    /// # Errors
    /// When a column or number is missing, times do not grow, or lines are of several robots.
    pub fn read(text: &str, robot: Option<&str>) -> Result<Self, RecordError> {
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let head = reader.headers().map_err(|error| RecordError::Table(error.to_string()))?.clone();
        let place = |name: &str| head.iter().position(|it| it == name);
        let needed = |name: &str| place(name).ok_or_else(|| RecordError::Column(name.to_owned()));
        let [time, x, y, yaw] = [needed("time")?, needed("x")?, needed("y")?, needed("yaw")?];
        let of_wheels =
            |what: &str| (1..).map_while(|wheel| place(&format!("wheel_{what}_{wheel}"))).collect::<Vec<_>>();
        let angles = of_wheels("angle");
        let are_angles = !angles.is_empty();
        let wheels = if are_angles { angles } else { of_wheels("speed") };
        if wheels.is_empty() {
            return Err(RecordError::Column("wheel_angle_1".to_owned()));
        }
        let column_of_robot = place("robot");
        let mut record = Self { times: Vec::new(), poses: Vec::new(), angles: Vec::new() };
        let mut known: Option<String> = None;
        for (number, row) in reader.records().enumerate() {
            let row = row.map_err(|error| RecordError::Table(error.to_string()))?;
            if number >= MAX_SAMPLES || wheels.len() > MAX_WHEELS {
                return Err(RecordError::Size);
            }
            let line = number + 2;
            if let Some(own) = column_of_robot.and_then(|column| row.get(column)) {
                match (robot, &known) {
                    (Some(wanted), _) if wanted != own => continue,
                    (None, Some(known)) if known != own => {
                        return Err(RecordError::Robots { one: known.clone(), other: own.to_owned() });
                    }
                    _ => known = Some(own.to_owned()),
                }
            }
            let cell = |column: usize| {
                let got = row.get(column).unwrap_or_default();
                let wrong = || RecordError::Cell { line, column: head[column].to_owned(), got: got.to_owned() };
                got.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(wrong)
            };
            let time = cell(time)?;
            let before = record.times.last().copied();
            if let Some(before) = before.filter(|&before| time <= before) {
                return Err(RecordError::Order { line, time, before });
            }
            let mut own: Vec<f64> = wheels.iter().map(|&wheel| cell(wheel)).collect::<Result<_, _>>()?;
            if !are_angles {
                // A speed holds since the sample before.
                let since = before.map_or(0.0, |before| time - before);
                let angles = record.angles.last().cloned().unwrap_or_else(|| vec![0.0; own.len()]);
                own.iter_mut().zip(angles).for_each(|(speed, angle)| *speed = angle + *speed * since);
            }
            record.poses.push([cell(x)?, cell(y)?, cell(yaw)?]);
            record.times.push(time);
            record.angles.push(own);
        }
        Ok(record)
    }

    /// Joins poses with the angles of wheels that were measured at other times. Each is a time, s, with x, y, m, and yaw, rad, or with the
    /// angles, rad. A pose gets the angles between its neighbours'; poses before the first and after the last angles are left out.
    ///
    /// # Errors
    /// When there are too many.
    pub fn join(mut poses: Vec<(f64, [f64; 3])>, mut wheels: Vec<(f64, Vec<f64>)>) -> Result<Self, RecordError> {
        let count = wheels.first().map_or(0, |(_, angles)| angles.len());
        if poses.len().max(wheels.len()) > MAX_SAMPLES || count > MAX_WHEELS {
            return Err(RecordError::Size);
        }
        poses.retain(|(time, pose)| time.is_finite() && pose.iter().all(|it| it.is_finite()));
        wheels.retain(|(time, angles)| time.is_finite() && angles.iter().all(|it| it.is_finite()));
        poses.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        poses.dedup_by(|(one, _), (other, _)| one <= other);
        wheels.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        wheels.dedup_by(|(one, _), (other, _)| one <= other);
        let mut record = Self { times: Vec::new(), poses: Vec::new(), angles: Vec::new() };
        let mut pairs = wheels.windows(2).peekable();
        for (time, pose) in poses {
            while pairs.next_if(|pair| pair[1].0 < time).is_some() {}
            let Some([(from, before), (to, after)]) = pairs.peek() else { break };
            if time < *from {
                continue;
            }
            let share = (time - from) / (to - from);
            record.times.push(time);
            record.poses.push(pose);
            record
                .angles
                .push(before.iter().zip(after).map(|(before, after)| before + share * (after - before)).collect());
        }
        Ok(record)
    }

    /// Returns the number of samples.
    pub(super) fn len(&self) -> usize {
        self.times.len()
    }

    /// Returns the number of wheels.
    pub(super) fn wheels(&self) -> usize {
        self.angles.first().map_or(0, Vec::len)
    }

    pub(super) fn time(&self, sample: usize) -> f64 {
        self.times[sample]
    }

    pub(super) fn pose(&self, sample: usize) -> [f64; 3] {
        self.poses[sample]
    }

    /// Returns the angle that each wheel turns from a sample to the next, rad.
    pub(super) fn turned(&self, sample: usize) -> Vec<f64> {
        self.angles[sample].iter().zip(&self.angles[sample + 1]).map(|(from, to)| to - from).collect()
    }
}
