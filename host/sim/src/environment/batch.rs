//! Many environments at once, on all processors.
//!
//! An environment whose episode has ended begins the next at the following step, whose action it
//! ignores: the convention of Gymnasium's `AutoresetMode.NEXT_STEP`.

use std::thread;

use armbridge_servo::JOINTS;

use super::{Environment, EnvironmentError, Observation, Transition};

/// Environments of one kind.
#[derive(Debug)]
pub struct Batch {
    environments: Vec<Environment>,
    /// Whose episodes have ended.
    ended: Vec<bool>,
    threads: usize,
}

impl Batch {
    /// So many environments of this description.
    ///
    /// # Errors
    /// If it is on a connected board.
    pub fn new(environment: &Environment, count: usize) -> Result<Self, EnvironmentError> {
        let environments = (0..count).map(|_| environment.another());
        Ok(Self {
            environments: environments.collect::<Result<_, _>>()?,
            ended: vec![true; count],
            threads: thread::available_parallelism().map_or(1, usize::from),
        })
    }

    /// The environments.
    pub fn environments(&self) -> &[Environment] {
        &self.environments
    }

    /// Begins an episode in each, after seeding it where there is a seed.
    ///
    /// # Errors
    /// That of the first environment that cannot be reset.
    pub fn reset(&mut self, seeds: &[Option<u64>]) -> Result<Vec<Observation>, EnvironmentError> {
        self.ended.fill(false);
        self.for_each(seeds, |environment, _, seed| {
            if let Some(seed) = seed {
                environment.seed(*seed);
            }
            environment.reset()
        })
    }

    /// Runs a step of each with its action.
    ///
    /// # Errors
    /// That of the first environment that cannot.
    pub fn step(&mut self, actions: &[[f64; JOINTS]]) -> Result<Vec<Transition>, EnvironmentError> {
        self.for_each(actions, |environment, has_ended, action| {
            if std::mem::take(has_ended) {
                let observation = environment.reset()?;
                return Ok(Transition {
                    observation,
                    reward: 0.0,
                    is_terminated: false,
                    is_truncated: false,
                });
            }
            let transition = environment.step(*action)?;
            *has_ended = transition.is_terminated || transition.is_truncated;
            Ok(transition)
        })
    }

    /// Calls `run` for each environment, in chunks, one on each processor.
    fn for_each<I: Sync, T: Send>(
        &mut self,
        inputs: &[I],
        run: impl Fn(&mut Environment, &mut bool, &I) -> Result<T, EnvironmentError> + Sync,
    ) -> Result<Vec<T>, EnvironmentError> {
        let chunk = self.environments.len().div_ceil(self.threads).max(1);
        let chunks = self.environments.chunks_mut(chunk);
        let chunks = chunks
            .zip(self.ended.chunks_mut(chunk))
            .zip(inputs.chunks(chunk));
        let run = &run;
        thread::scope(|scope| {
            let all = chunks.map(|((environments, ended), inputs)| {
                move || {
                    let all = environments.iter_mut().zip(ended).zip(inputs);
                    let all =
                        all.map(|((environment, ended), input)| run(environment, ended, input));
                    all.collect::<Result<Vec<T>, _>>()
                }
            });
            let mut all: Vec<_> = all.collect();
            // The last chunk is the calling thread's.
            let own = all.pop();
            let others: Vec<_> = all.into_iter().map(|run| scope.spawn(run)).collect();
            let own = own.map(|run| run());
            let mut results = Vec::with_capacity(inputs.len());
            for other in others {
                let joined = other.join();
                results.extend(joined.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?);
            }
            results.extend(own.transpose()?.into_iter().flatten());
            Ok(results)
        })
    }
}
