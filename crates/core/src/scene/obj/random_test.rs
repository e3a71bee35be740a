//! OBJ and MTL texts that nobody wrote.

use std::path::Path;

use super::mtl_test::materials;
use super::parse;
use super::test::{assert_readable, assert_sound};

/// xorshift64*, to have the same texts every time.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize % n
    }
}

/// A text with some bytes replaced, removed, repeated or made of a record's own.
fn mutate(seed: &str, random: &mut Random) -> Vec<u8> {
    const PIECES: [&str; 24] = [
        "nan",
        "-",
        "1e999",
        "0",
        "//",
        "/",
        "\\\n",
        "\r",
        "\n",
        " ",
        "#",
        "f",
        "v",
        "vt 1",
        "usemtl ",
        "mtllib ",
        "99999999999",
        "-9",
        "Kd 1",
        "newmtl ",
        "illum 7\n",
        "map_Kd -s 1 ",
        "\u{85}",
        "\u{feff}",
    ];
    let mut bytes = seed.as_bytes().to_vec();
    for _ in 0..=random.below(3) {
        let from = random.below(bytes.len());
        let to = (from + random.below(12)).min(bytes.len());
        match random.below(4) {
            0 => bytes[from] = random.below(256) as u8,
            1 if to - from < bytes.len() => drop(bytes.drain(from..to)),
            2 => {
                let piece = bytes[from..to].to_vec();
                let at = random.below(bytes.len());
                bytes.splice(at..at, piece);
            }
            _ => drop(bytes.splice(from..from, PIECES[random.below(PIECES.len())].bytes())),
        }
    }
    bytes
}

/// Whatever a text says, it is refused in one line or makes a sound mesh.
#[test]
fn random_texts_neither_panic_nor_make_unsound_meshes() {
    const OBJ: &str = "# seed\nmtllib a.mtl\nv 0 0 0\nv 1 0 0 1\nv 1 1 0\nv 0 1 0.5\nv .5 .5 1e0\nv .2 .3 .1\n\
        vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nusemtl a b\nf 1/1/1 2/2/1 3/3/1\nf 1//1 2//1 \\\n 3//1 4//1\n\
        f -1 -2 -3 -4 -5 -6\nl 1 2\nusemtl c\nf 6 3 1 5 4\n";
    const MTL: &str = "newmtl a b\nKd .1 .2 .3\nKs 0.5\nillum 3\nNi 1.5\nmap_Kd -s 1 1 1 -bm 1 a b.png\n\
        newmtl c\nKe 1 2 3\nKd 1\nd .5\nillum 7\nNi 1.33\n";
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let (mut meshes, mut libraries) = (0, 0);
    for _ in 0..20_000 {
        let bytes = mutate(OBJ, &mut random);
        match parse(&bytes, Path::new("random.obj")) {
            Ok(mesh) => {
                assert_sound(&mesh);
                meshes += 1;
            }
            Err(error) => assert_readable(&error),
        }
        libraries +=
            usize::from(materials(&String::from_utf8_lossy(&mutate(MTL, &mut random))).is_ok());
    }
    // Both outcomes must come up often, or the texts test nothing.
    assert!(
        (3_000..17_000).contains(&meshes) && (3_000..17_000).contains(&libraries),
        "{meshes} {libraries}"
    );
}
