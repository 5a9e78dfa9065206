//! Channels of a log: which topic each number stands for.

use mcap::records::{Record, op};

use super::Reader;
use crate::limits::quote;
use crate::mcap_records::{parse, split};
use crate::topics::Topic;

impl Reader {
    /// Reads up to the channels of a link's topics, which precede all messages.
    pub(super) fn find_channels(&mut self) -> Result<(), String> {
        while self.channels.is_empty() {
            if !self.load_chunk().map_err(|error| error.to_string())? {
                let why = self.damage.last().map(|last| format!(": {last}"));
                let why = why.unwrap_or_default();
                return Err(format!("it breaks off before anything was recorded{why}"));
            }
            let chunk = std::mem::take(&mut self.chunk);
            let mut rest = chunk.get(self.at..).unwrap_or_default();
            while let Some((opcode, body, after)) = split(rest) {
                rest = after;
                if opcode == op::CHANNEL {
                    self.register_channel(body)?;
                }
            }
            self.chunk = chunk;
        }
        Ok(())
    }

    pub(super) fn register_channel(&mut self, body: &[u8]) -> Result<(), String> {
        let Some(Record::Channel(channel)) = parse(op::CHANNEL, body) else {
            return Ok(());
        };
        if channel.topic.starts_with("/armbridge/") {
            return Err(
                "it is a log of an early version, in JSON; record events, or read it with the \
                 version that wrote it"
                    .into(),
            );
        }
        let is_ours = |topic: &Topic| topic.name() == channel.topic;
        match Topic::ALL.into_iter().find(is_ours) {
            Some(topic) if channel.message_encoding == "protobuf" => {
                self.channels.insert(channel.id, topic);
                Ok(())
            }
            // Another program added a topic: harmless if ours are there too.
            Some(_) | None if !self.channels.is_empty() => Ok(()),
            Some(_) | None => Err(format!(
                "it is an MCAP file, but no log of Armbridge: it has the topic {}",
                quote(&channel.topic)
            )),
        }
    }
}
