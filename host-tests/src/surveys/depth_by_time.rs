//! Depths from a CSV file by time.

use super::{
    cells::{each_once, line, number, one_group, stated, table, unmarked, unread},
    column_names::{DEPTHS, Units, named},
};
use testbed::failure::Failure;

/// Depths of the bit by time, to give stations by time their depths.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthByTime(Vec<[f64; 2]>);

impl DepthByTime {
    /// Reads the text of a file with the columns `t_s` and `md_m`. `offset_m` is the distance from the bit to the
    /// tool, `clock_s` what is added to the file's clock to get the tool's.
    ///
    /// # Errors
    /// The first line or column that cannot be used, and why.
    pub fn read(text: &str, offset_m: f64, clock_s: f64) -> Result<Self, Failure> {
        Self::rows(text, offset_m, clock_s).map_err(|why| Failure::BadInput(format!("depth file: {why}")))
    }

    fn rows(text: &str, offset_m: f64, clock_s: f64) -> Result<Self, String> {
        let text = unmarked(text);
        let mut reader = table(text);
        let header = reader.headers().map_err(|error| unread(&error))?.clone();
        let units = stated(text, "units").map(Units::parse).transpose()?;
        let names: Vec<String> = header.iter().map(|column| named(column, units.as_ref())).collect();
        each_once(&header, &names, DEPTHS.map(|(name, _)| name).into_iter().chain(["t_s"]))?;
        one_group(&header, &names, "depth", DEPTHS.iter().map(|(name, _)| std::slice::from_ref(name)))?;
        let find = |name: &str| names.iter().position(|column| column == name);
        let depth = DEPTHS.iter().find_map(|(name, factor)| Some((find(name)?, *factor)));
        let (Some(time), Some((depth, metres))) = (find("t_s"), depth) else {
            let has = header.iter().collect::<Vec<_>>().join(", ");
            return Err(format!(
                "lacks a column t_s, or md_m, md_ft or md_usft: the first line must name them, and says {has:?}"
            ));
        };
        let mut points: Vec<[f64; 2]> = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| unread(&error))?;
            let [t, md] = [number(&header, &record, time)?, metres * number(&header, &record, depth)?];
            if points.last().is_some_and(|[last, _]| t + clock_s <= *last) {
                return Err(format!(
                    "line {}: time does not increase: sort the rows by t_s, each time once",
                    line(&record)
                ));
            }
            points.push([t + clock_s, md - offset_m]);
        }
        Ok(Self(points))
    }

    /// First and last time, by the tool's clock; `None` without a line.
    #[must_use]
    pub fn span_s(&self) -> Option<[f64; 2]> {
        Some([self.0.first()?[0], self.0.last()?[0]])
    }

    /// Depth of the tool at a time, between the file's lines; `None` outside of it.
    #[must_use]
    pub fn at(&self, t_s: f64) -> Option<f64> {
        self.0.windows(2).find_map(|pair| match pair {
            [[t0, md0], [t1, md1]] if t_s >= *t0 && t_s <= *t1 => Some(md0 + (md1 - md0) * (t_s - t0) / (t1 - t0)),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::{super::column_names::FOOT_M, *};

    #[test]
    fn a_depth_file_of_another_program_is_read_and_its_faults_are_told_with_their_lines() {
        let depth = DepthByTime::read("Time (s);Depth (ft)\n0;1000\n100;1100\n", 0.0, 0.0).unwrap();
        assert!((depth.at(50.0).unwrap() - 1_050.0 * FOOT_M).abs() < 1e-9);
        let marked = "\u{feff}# Units = ft g nT\nt_s,MD\n0,1000\n100,1100\n";
        assert_eq!(DepthByTime::read(marked, 0.0, 0.0).unwrap(), depth);
        for (text, told) in [
            ("", "lacks a column t_s"),
            ("time,depth\n1,2\n", "says \"time, depth\""),
            ("t_s,md_m\n1,2\n1,3\n", "line 3: time does not increase"),
            ("t_s,Depth (m),MD (m)\n0,1,2\n", "columns \"Depth (m)\" and \"MD (m)\" are both md_m"),
            ("# units = m g nT\nt_s,MD (yd)\n0,1\n", "lacks a column t_s, or md_m"),
            ("t_s,md_m\n1,NaN\n", "line 2: column md_m: \"NaN\" is no number"),
        ] {
            let error = DepthByTime::read(text, 0.0, 0.0).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }

    #[test]
    fn depth_by_time_is_the_bits_less_the_distance_to_the_tool_by_the_tools_clock() {
        let depth = DepthByTime::read("t_s,md_m\n0,1000\n100,1010\n", 15.0, 7.0).unwrap();
        assert_eq!(depth.at(57.0), Some(990.0));
        assert_eq!((depth.at(6.9), depth.at(107.1)), (None, None));
    }
}
