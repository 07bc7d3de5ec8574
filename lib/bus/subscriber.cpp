#include "bus/subscriber.hpp"

#include <array>
#include <lcm/lcm-cpp.hpp>

#include "core/error.hpp"

namespace ballbar {

struct Subscriber::Impl {
  struct Input {
    Impl* owner;
    Channel channel;
    void receive(const lcm::ReceiveBuffer* buffer, const std::string&) {
      // LCM can hand over sizes near 2^32: walk() refuses them by their size before it looks at a byte.
      const auto* data = static_cast<const std::uint8_t*>(buffer->data);
      owner->handler(channel, {data, buffer->data_size}, buffer->recv_utime);
    }
  };

  Impl(const std::string& url, RawHandler h, std::function<void()> p)
      : lcm(url), handler(std::move(h)), pulse(std::move(p)) {}

  void on_pulse(const lcm::ReceiveBuffer*, const std::string&) { pulse(); }

  lcm::LCM lcm;
  RawHandler handler;
  std::function<void()> pulse;
  std::array<Input, kInputChannels.size()> inputs{};
};

Subscriber::Subscriber(const std::string& url, RawHandler handler, std::function<void()> pulse)
    : impl_(std::make_unique<Impl>(url, std::move(handler), std::move(pulse))) {
  if (!impl_->lcm.good())
    throw Error(Cause::kWorld,
                "bus " + url +
                    ": cannot be opened; is there a multicast route? 'ip route add 239.255.76.67/32 dev lo "
                    "src 127.0.0.1' makes one on this machine");
  // Asked before subscribing: where multicast does not come back, LCM returns a subscription without content.
  if (impl_->lcm.getFileno() < 0)
    throw Error(
        Cause::kWorld,
        "bus " + url + ": multicast does not come back to this machine; look at its firewall and route");
  for (std::size_t i = 0; i < kInputChannels.size(); ++i) {
    const ChannelInfo& info = kInputChannels[i];
    impl_->inputs[i] = {impl_.get(), info.channel};
    lcm::Subscription* subscription =
        impl_->lcm.subscribe(info.name, &Impl::Input::receive, &impl_->inputs[i]);
    subscription->setQueueCapacity(info.queue_capacity);
  }
  if (impl_->pulse) impl_->lcm.subscribe(kPulseChannel, &Impl::on_pulse, impl_.get())->setQueueCapacity(2);
}

Subscriber::~Subscriber() = default;

int Subscriber::fd() const { return impl_->lcm.getFileno(); }

void Subscriber::publish(Channel channel, std::span<const std::uint8_t> bytes) {
  impl_->lcm.publish(channel_name(channel), bytes.data(), static_cast<unsigned>(bytes.size()));
}

bool Subscriber::handle() { return impl_->lcm.handle() == 0; }

}  // namespace ballbar
