// Fields of an address by explicit bits: "13 12 11", each bit the XOR of several where a hash is wanted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// One bit of a field: the parity of the address bits in `mask`. `own` is the bit that the field takes out of
// the address; the others also serve where they stand.
struct AddressBit {
    int own = 0;
    std::uint64_t mask = 0;
};

// `text` names the field's bits from high to low, separated by blanks, each as a bit number of a byte address
// or several joined by '^', its own first ("14^20 13^19 12"). Returned from low to high. Throws UserError at
// `where` on anything else, on a bit named twice in a term, and on two terms with the same own bit.
std::vector<AddressBit> parse_address_bits(const std::string& text, const std::string& where);

// The rank of a square or oblong matrix over GF(2), a word a row: rows that no XOR of others makes.
int binary_rank(std::vector<std::uint64_t> rows);

}  // namespace ropsim
