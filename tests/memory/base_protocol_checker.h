// Stands between an initiator and a target and holds both to the TLM-2.0 base protocol (IEEE
// 1666-2011, 15.2).
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <tlm>
#include <vector>

#include <fmt/format.h>
#include <tlm_utils/simple_initiator_socket.h>
#include <tlm_utils/simple_target_socket.h>

namespace ropsim {

// Passes every nb_transport call through, in the same call and at the same time. What it checks:
//   - a transaction's phases come in order, each side sends its own, and return values fit them
//   - no BEGIN_REQ before the one before it has its END_REQ, no BEGIN_RESP before END_RESP
//   - the effective times of a transaction's phases do not go back, nor do those of requests or of responses
//   - the payload has a memory manager and is held while in flight, its attributes stay as the initiator set
//   them,
//     the response status is written once, by the target, before the response
// Call finish() after the simulation.
class BaseProtocolChecker : public sc_core::sc_module {
 public:
    explicit BaseProtocolChecker(const sc_core::sc_module_name& name)
        : sc_module(name), target("target"), initiator("initiator") {
        target.register_nb_transport_fw(this, &BaseProtocolChecker::forward);
        initiator.register_nb_transport_bw(this, &BaseProtocolChecker::backward);
    }

    tlm_utils::simple_target_socket<BaseProtocolChecker> target;        // bind the initiator to this
    tlm_utils::simple_initiator_socket<BaseProtocolChecker> initiator;  // bind this to the target

    // Everything was answered and given back.
    void finish() {
        for (const auto& [payload, transaction] : open_) fail("a transaction without an end", transaction);
        for (const tlm::tlm_generic_payload* payload : seen_)
            if (payload->get_ref_count() != 0)
                fail(fmt::format("{} references left", payload->get_ref_count()), {});
    }
    const std::vector<std::string>& violations() const { return violations_; }
    std::uint64_t transactions() const { return transactions_; }
    std::uint64_t refusals = 0;  // requests whose END_REQ did not come in the same call

 private:
    using Payload = tlm::tlm_generic_payload;
    enum class State { kBeginReq, kEndReq, kBeginResp };
    // What the initiator set.
    struct Attributes {
        tlm::tlm_command command;
        std::uint64_t address;
        unsigned char* data;
        unsigned int length, streaming_width;
        unsigned char* byte_enable;
        unsigned int byte_enable_length;
        bool operator==(const Attributes&) const = default;
    };
    struct Transaction {
        std::uint64_t number = 0;
        State state = State::kBeginReq;
        Attributes attributes{};
        sc_core::sc_time last;
        tlm::tlm_response_status status = tlm::TLM_INCOMPLETE_RESPONSE;
    };

    static Attributes attributes_of(const Payload& p) {
        return {p.get_command(),           p.get_address(),         p.get_data_ptr(),
                p.get_data_length(),       p.get_streaming_width(), p.get_byte_enable_ptr(),
                p.get_byte_enable_length()};
    }
    void fail(const std::string& what, const Transaction& transaction) {
        if (violations_.size() < 100)
            violations_.push_back(fmt::format("transaction {}: {}", transaction.number, what));
    }

    // A phase at its effective time.
    void advance(Transaction& transaction, const sc_core::sc_time& delay, const char* phase) {
        const sc_core::sc_time moment = sc_core::sc_time_stamp() + delay;
        if (moment < transaction.last) fail(fmt::format("{} goes back in time", phase), transaction);
        transaction.last = moment;
    }
    void in_order(sc_core::sc_time& newest, const sc_core::sc_time& delay, const char* phase,
                  const Transaction& transaction) {
        const sc_core::sc_time moment = sc_core::sc_time_stamp() + delay;
        if (moment < newest) fail(fmt::format("{} before an earlier transaction's", phase), transaction);
        newest = moment;
    }
    void check_payload(const Payload& payload, Transaction& transaction, bool answered) {
        if (!(attributes_of(payload) == transaction.attributes)) fail("attributes were changed", transaction);
        if (payload.get_ref_count() < 1) fail("nobody holds the payload", transaction);
        const tlm::tlm_response_status status = payload.get_response_status();
        if (answered && status == tlm::TLM_INCOMPLETE_RESPONSE)
            fail("a response without a status", transaction);
        if (!answered && status != tlm::TLM_INCOMPLETE_RESPONSE)
            fail("a status before the response", transaction);
        transaction.status = status;
    }
    void check_new(const Payload& payload, const Transaction& transaction) {
        if (!payload.has_mm()) fail("no memory manager", transaction);
        if (payload.get_data_length() == 0 || payload.get_streaming_width() == 0)
            fail("a length of 0", transaction);
        if (payload.is_dmi_allowed()) fail("DMI is allowed before the target said so", transaction);
    }

    tlm::tlm_sync_enum forward(Payload& payload, tlm::tlm_phase& phase, sc_core::sc_time& delay) {
        if (phase == tlm::BEGIN_REQ) return begin_request(payload, phase, delay);
        const auto at = open_.find(&payload);
        if (phase != tlm::END_RESP || at == open_.end()) {
            fail(fmt::format("{} from the initiator", phase.get_name()), {});
            return initiator->nb_transport_fw(payload, phase, delay);
        }
        Transaction& transaction = at->second;
        if (transaction.state != State::kBeginResp) fail("END_RESP before BEGIN_RESP", transaction);
        advance(transaction, delay, "END_RESP");
        check_payload(payload, transaction, true);
        end(payload);
        const tlm::tlm_sync_enum answer = initiator->nb_transport_fw(payload, phase, delay);
        if (answer == tlm::TLM_UPDATED) fail("END_RESP answered by TLM_UPDATED", {});
        return answer;
    }

    tlm::tlm_sync_enum begin_request(Payload& payload, tlm::tlm_phase& phase, sc_core::sc_time& delay) {
        Transaction fresh;
        fresh.number = transactions_++;
        fresh.attributes = attributes_of(payload);
        if (open_.count(&payload) != 0) fail("the payload is still in use", fresh);
        if (requesting_ != nullptr) fail("BEGIN_REQ before the last END_REQ", fresh);
        check_new(payload, fresh);
        advance(fresh, delay, "BEGIN_REQ");
        in_order(last_request_, delay, "BEGIN_REQ", fresh);
        check_payload(payload, fresh, false);
        open_[&payload] = fresh;
        seen_.insert(&payload);
        requesting_ = &payload;
        const tlm::tlm_sync_enum answer = initiator->nb_transport_fw(payload, phase, delay);
        // What the target has said by calling back counts first.
        const auto at = open_.find(&payload);
        if (answer == tlm::TLM_ACCEPTED) {
            if (at != open_.end() && at->second.state == State::kBeginReq) ++refusals;
            return answer;
        }
        if (at == open_.end()) {
            fail("answered twice", fresh);
            return answer;
        }
        Transaction& transaction = at->second;
        if (answer == tlm::TLM_COMPLETED) {
            advance(transaction, delay, "TLM_COMPLETED");
            check_payload(payload, transaction, true);
            end(payload);
        } else {
            target_phase(payload, transaction, phase, delay);
        }
        return answer;
    }

    tlm::tlm_sync_enum backward(Payload& payload, tlm::tlm_phase& phase, sc_core::sc_time& delay) {
        const auto at = open_.find(&payload);
        if (at == open_.end()) {
            fail(fmt::format("{} of no transaction", phase.get_name()), {});
            return target->nb_transport_bw(payload, phase, delay);
        }
        target_phase(payload, at->second, phase, delay);
        const tlm::tlm_phase sent = phase;
        const tlm::tlm_sync_enum answer = target->nb_transport_bw(payload, phase, delay);
        const auto still = open_.find(&payload);
        if (answer == tlm::TLM_ACCEPTED || still == open_.end()) return answer;
        if (sent != tlm::BEGIN_RESP) {
            fail("only a response can be completed", still->second);
            return answer;
        }
        if (answer == tlm::TLM_UPDATED && phase != tlm::END_RESP)
            fail("BEGIN_RESP answered by another phase than END_RESP", still->second);
        advance(still->second, delay, "END_RESP");
        // A payload that is given back may already be the next request's: its attributes are not looked at.
        end(payload);
        return answer;
    }

    // END_REQ or BEGIN_RESP, by a call or by a return value.
    void target_phase(Payload& payload, Transaction& transaction, const tlm::tlm_phase& phase,
                      const sc_core::sc_time& delay) {
        advance(transaction, delay, phase.get_name());
        if (phase == tlm::END_REQ) {
            if (transaction.state != State::kBeginReq) fail("END_REQ out of order", transaction);
            transaction.state = State::kEndReq;
            check_payload(payload, transaction, false);
        } else if (phase == tlm::BEGIN_RESP) {
            if (transaction.state == State::kBeginResp) fail("BEGIN_RESP out of order", transaction);
            if (responding_ != nullptr) fail("BEGIN_RESP before the last END_RESP", transaction);
            in_order(last_response_, delay, "BEGIN_RESP", transaction);
            check_payload(payload, transaction, true);
            transaction.state = State::kBeginResp;
            responding_ = &payload;
        } else {
            fail(fmt::format("{} from the target", phase.get_name()), transaction);
        }
        if (requesting_ == &payload) requesting_ = nullptr;
    }

    void end(Payload& payload) {
        if (requesting_ == &payload) requesting_ = nullptr;
        if (responding_ == &payload) responding_ = nullptr;
        open_.erase(&payload);
    }

    std::map<Payload*, Transaction> open_;
    std::set<const Payload*> seen_;
    Payload* requesting_ = nullptr;
    Payload* responding_ = nullptr;
    sc_core::sc_time last_request_, last_response_;
    std::uint64_t transactions_ = 0;
    std::vector<std::string> violations_;
};

}  // namespace ropsim
