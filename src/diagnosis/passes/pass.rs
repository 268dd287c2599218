//! One walk through the samples, with the solution so far taken out.

use super::*;

impl Diagnosis {
    pub(super) fn start_pass(&mut self, subject: &Subject) {
        self.next = self.job.from;
        self.ending = Ending::Scales;
        self.test = 0;
        self.usable_before = self.usable;
        self.usable = 0;
        (self.p, self.c) = self.gyro(subject);
        self.walk.start(subject.stream, self.job.from, (&self.p, &self.c, &self.step));
        RateErrors::new(self.factor.scratch()).clear();
        self.rate_sums = [Vector3::zeros(); 2];
        self.columns.start(subject.stream.test_function.hop());
        self.normal.clear();
        self.scores.fill(0.0);
        let mut taken_out = ActiveEffects::none();
        for &Chosen { index, .. } in &self.chosen {
            if self.columns_of(subject, usize::from(index)).is_empty() {
                continue;
            }
            let parameters = self.parameters(subject, usize::from(index));
            taken_out.add(FoundEffect { index, parameters, ..FoundEffect::default() });
        }
        self.taken_out = taken_out;
        self.residual_sums = [[0.0; 2]; 2];
        self.nis_sums = [0.0; 2];
        if !self.is_final {
            self.remainder.start(subject.stream.test_function.hop(), subject.stream.grid.interval_s());
        }
        for chosen in &mut self.chosen {
            chosen.turned = [0.0; 2];
            chosen.turned_by = [0.0; MAX_PARAMETERS];
        }
    }

    #[inline(never)]
    pub(super) fn take(&mut self, subject: &Subject, index: u32) {
        let scales = GyroScales::new(&subject.config.identification);
        let mut instant = self.walk.advance((subject.stream, self.job.to), index, (&self.p, &self.c, &self.step));
        self.rate_sums[0] += instant.raw_rad_s;
        self.rate_sums[1] += instant.moment.rate_rad_s;
        let read = instant.moment;
        self.taken_out.correct_vectors(subject.library, &mut instant.moment);
        self.measure_turns(subject, &read);
        if !self.is_final {
            self.remainder.watch(&instant);
        }
        let function = &subject.stream.test_function;
        let moving = subject.config.identification.max_bias_rad_s;
        let library = (subject.library, &self.layout);
        if let Some((facts, number)) = self.columns.push(&instant, function, library, &scales, moving) {
            self.take_test(subject, &facts, number, function.noise_gain());
            self.columns.clear(number);
        }
    }
}
