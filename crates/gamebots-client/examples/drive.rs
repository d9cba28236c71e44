//! Drives a youBot half a metre to the right, by its ground truth.

use std::time::Duration;

use gamebots_client::Client;
use gamebots_proto::message::{Message, Reading};

fn main() -> std::io::Result<()> {
    let address = std::env::args().nth(1).unwrap_or("127.0.0.1:3000".to_owned());
    let mut client = Client::connect(address)?;
    client.send("INIT {ClassName USARBot.KUKA_YouBot} {Name Rust} {Location -2,0,0}")?;
    client.send("DRIVE {Front-Left 2} {Front-Right -2} {Back-Left -2} {Back-Right 2}")?;
    while let Some(line) = client.next_line(Duration::from_secs(5))? {
        let Some(Message::Sen(sen)) = Message::read(&line) else { continue };
        if let Reading::GroundTruth(truth) = sen.reading
            && truth.location[1] > 0.5
        {
            client.send("DRIVE {Left 0} {Right 0}")?;
            println!("arrived at y = {:.3}", truth.location[1]);
            break;
        }
    }
    Ok(())
}
